"""The rules of the contract that can be seen from outside, and what was found of each."""

from dataclasses import dataclass
from enum import StrEnum

PAGE = "docs/robots.md"


class Rule(StrEnum):
    """What a robot has to do; the value is its name in reports, `words` says it."""

    words: str

    def __new__(cls, value: str, words: str) -> "Rule":
        member = str.__new__(cls, value)
        member._value_ = value
        member.words = words
        return member

    ANNOUNCES = "announces", "It publishes a factsheet for the run that the world is in."
    CONNECTION = "connection", "It says that it is online."
    RETAINED = "retained", "It publishes factsheet and connection retained, and nothing else."
    QOS = "qos", "It publishes telemetry with QoS 0, and everything else with QoS 1."
    WELL_FORMED = (
        "well-formed",
        "Its messages have the envelope, its own name as sender, and the run as user property.",
    )
    STATUS = "status", "It answers status queries, also on a script that it does not know."
    UNKNOWN_FIELDS = "unknown-fields", "It accepts messages with fields that it does not know."
    UNKNOWN_KINDS = "unknown-kinds", "It answers messages of kinds that it does not know with not-understood."
    OTHER_RUNS = "other-runs", "It ignores messages of another run of the world."
    REFUSES = "refuses", "It refuses a script with a packet that it does not have, with a reason."
    ACKNOWLEDGES = "acknowledges", "It acknowledges a script."
    ONCE = "once", "It answers a repeated request again and does not follow it twice."
    IN_ORDER = (
        "in-order",
        "It reports each packet running, then finished, in order, and then the script's end.",
    )
    RECEIPTS = "receipts", "It repeats a report, with the same id, until its receipt."
    CLEARANCE = (
        "clearance",
        "It begins a packet that waits for others' actions once they are cleared, not before.",
    )
    PAUSES = "pauses", "It pauses a script."
    RESUMES = "resumes", "It resumes a paused script."
    ORDER_NUMBERS = "order-numbers", "It refuses an order with a lower number than one that it has followed."
    CANCELS = "cancels", "It cancels a script, and reports it as cancelled."
    STALE = "stale", "It refuses a script that was cancelled before it arrived."
    TELEMETRY = "telemetry", "Its telemetry is well formed."
    LAST_WILL = "last-will", "The broker says `connection_broken` for it once its connection is lost."
    RECONNECTS = (
        "reconnects",
        "It goes on with its script without a connection, comes back, and reports what happened meanwhile.",
    )

    @property
    def link(self) -> str:
        """Where the rule is explained."""
        return f"{PAGE}#{self.value}"


class Verdict(StrEnum):
    """What was seen of a rule."""

    KEPT = "kept"
    """The robot did as the rule says."""
    BROKEN = "broken"
    """It did not."""
    UNTRIED = "untried"
    """It could not be tried."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A rule's verdict; `detail` says what was seen, or why it was not tried."""

    rule: Rule
    verdict: Verdict
    detail: str = ""
