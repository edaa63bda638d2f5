"""Speech acts between robots, and to a robot on a person's behalf: FIPA ACL (SC00061) in the envelope of a `Message`.

The envelope's id is FIPA's reply-with, its `in_reply_to` in-reply-to. A message to several has one envelope each.
"""

from typing import Literal

from pydantic import Field

from robots.data import StrEnum
from robots.wire.script import BehaviourScript, Wire

TERMS = "macta-terms"
"""The language of contents: ground terms such as `ended(script_1, a5)`."""
MAX_CONTENT = 4000


class Performative(StrEnum):
    """FIPA's communicative acts (SC00037), and `query`, the service's question for a state, trace or tuning."""

    ACCEPT_PROPOSAL = "accept-proposal"
    AGREE = "agree"
    CANCEL = "cancel"
    CFP = "cfp"
    CONFIRM = "confirm"
    DISCONFIRM = "disconfirm"
    FAILURE = "failure"
    INFORM = "inform"
    INFORM_IF = "inform-if"
    INFORM_REF = "inform-ref"
    NOT_UNDERSTOOD = "not-understood"
    PROPAGATE = "propagate"
    PROPOSE = "propose"
    PROXY = "proxy"
    QUERY = "query"
    QUERY_IF = "query-if"
    QUERY_REF = "query-ref"
    REFUSE = "refuse"
    REJECT_PROPOSAL = "reject-proposal"
    REQUEST = "request"
    REQUEST_WHEN = "request-when"
    REQUEST_WHENEVER = "request-whenever"
    SUBSCRIBE = "subscribe"


class SpeechAct(Wire):
    """Robot to robot: what the message's performative is about (any performative).

    `content`: a term of `language`, whose words mean what `ontology` says. `conversation_id`: what belongs together
    of one `protocol`. `reply_by_s`: the sender waits for an answer until then. `receivers`: all that it is said to, if
    there are several. `speaker`: the person on whose behalf it is said; empty if the sender speaks for itself.
    `attempt`: counts how often the sender has said this message. `script`: with an award by a robot, by which
    the receiver does the leg.
    """

    kind: Literal["speech_act"] = "speech_act"
    content: str = Field(max_length=MAX_CONTENT)
    language: str = Field(default=TERMS, max_length=64)
    ontology: str = Field(default="", max_length=64)
    protocol: str = Field(default="", max_length=64)
    conversation_id: str = Field(min_length=1, max_length=120)
    reply_by_s: float | None = None
    receivers: tuple[str, ...] = Field(default=(), max_length=256)
    speaker: str = Field(default="", max_length=64)
    attempt: int = Field(default=1, ge=1)
    script: BehaviourScript | None = None


class SpeechReport(Wire):
    """Robot to service: what another robot has said to it that concerns this script, and its answer (inform).

    `sent_at_s`: by the sender's clock; `at_s`: when it was heard; `attempt`: of the copy that was heard first.
    """

    kind: Literal["speech_report"] = "speech_report"
    script_id: str
    sender: str
    performative: Performative
    content: str = Field(max_length=MAX_CONTENT)
    protocol: str = ""
    conversation_id: str = ""
    sent_at_s: float
    at_s: float
    attempt: int = Field(default=1, ge=1)
    answer: Performative
    answer_content: str = Field(default="", max_length=MAX_CONTENT)
