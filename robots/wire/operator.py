"""The messages by which an operator drives a robot, tunes its packets and inspects its synthesis and mind."""

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from robots.wire.script import Wire

VALID_AT_MOST_S = 5.0
"""The longest time for which one set-point moves a robot (world's clock)."""
MAX_SPEED_M_S = 0.3
MAX_TURN_RAD_S = 1.0
"""Limits of a driven robot: an operator sees little, and with a delay (our choice)."""
RELEASE_FACTOR = 6.0
"""The drive ends this many times a set-point's validity after the last set-point."""
TRACED_S = 60.0
"""The approximate length of the trace that a robot keeps."""

MAX_TOLD = 256
"""Beliefs, and commitments, in one report, shared evenly by the agents (our choice)."""
MAX_TOLD_CONVERSATIONS = 64
MAX_TOLD_MESSAGES = 32
"""The last that were heard, in one report (our choice)."""
MAX_TOLD_CHARACTERS = 200
"""Of one text; longer ones end in an ellipsis."""
MAX_TOLD_BINDINGS = 16

MAX_RULE_FILES = 16
RuleText = Annotated[str, StringConstraints(max_length=64 * 1024)]
"""The text of one rule file (docs/rules.md)."""

PacketTunings = dict[str, dict[str, dict[str, float]]]
"""Packet tag, pattern ("dof/name") and parameter ("stimulus.reach_m") to its new value."""
NormalisedUtilitor = tuple[float, float]
"""Response in [-1, 1], utility in [0, 1]."""


class SetPoint(Wire):
    """Service to robot: drive like this until the next set-point arrives, at most for `valid_s` (request).

    Set-points are never kept or repeated. Of two, the one with the greater `number` counts. `driver` identifies one
    drive, from taking control to releasing it; `ends`: the driver releases control.
    """

    kind: Literal["set_point"] = "set_point"
    driver: str = Field(min_length=1, max_length=200)
    number: int = Field(ge=0)
    speed_m_s: float = 0.0
    turn_rad_s: float = 0.0
    valid_s: float = Field(gt=0, le=VALID_AT_MOST_S)
    ends: bool = False


class SetPointRefusal(Wire):
    """Robot to service: why it does not follow the driver's set-point (refuse). Telemetry shows that it does."""

    kind: Literal["set_point_refusal"] = "set_point_refusal"
    driver: str
    reason: str


class Retune(Wire):
    """Service to robot: use these parameters from the next packet on (request).

    They are applied on top of the robot's initial tuning and replace those sent before. `version` counts up.
    """

    kind: Literal["retune"] = "retune"
    version: int = Field(ge=0)
    tuning: PacketTunings


class TuningReport(Wire):
    """Robot to service: the tuning of that version is used (agree), or refused for a reason (refuse)."""

    kind: Literal["tuning_report"] = "tuning_report"
    version: int
    reason: str = ""


class RuleSet(Wire):
    """Service to robot: follow these rule files from now on (request).

    They replace those sent before; none: no rules. `files`: the text of each by the name of its agent or role, agents
    in order of rank. `version` counts up. `role`: what the robot plays, believed by each agent as `role(NAME)`; empty:
    no role.
    """

    kind: Literal["rule_set"] = "rule_set"
    version: int = Field(ge=0)
    files: dict[str, RuleText] = Field(default_factory=dict, max_length=MAX_RULE_FILES)
    role: str = Field(default="", max_length=64)


class RulesReport(Wire):
    """Robot to service: the rules of that version are followed (agree), or refused for a reason (refuse).

    `digests`: of the files that are followed now, by name, so that each side knows which text the other means. `role`:
    what it plays now; empty: no role.
    """

    kind: Literal["rules_report"] = "rules_report"
    version: int
    reason: str = ""
    digests: dict[str, str] = Field(default_factory=dict)
    role: str = Field(default="", max_length=64)


class TraceQuery(Wire):
    """Service to robot: send the trace of the last seconds (query)."""

    kind: Literal["trace_query"] = "trace_query"
    seconds: float = Field(gt=0, le=TRACED_S)


class TracedPattern(Wire):
    """A behaviour pattern by name, "dof/name", and its level."""

    name: str
    level: str


class TracedTick(Wire):
    """One tick: the utilitors of patterns and resultants, in the stretch's order, and the velocity command.

    The velocity is that after obstacle avoidance.
    """

    at_s: float
    patterns: tuple[NormalisedUtilitor, ...]
    resultants: tuple[NormalisedUtilitor, ...]
    linear_m_s: float
    angular_rad_s: float


class TracedStretch(Wire):
    """Successive ticks with the same packet and active patterns. `dofs` are the resultants' degrees of freedom."""

    packet_id: str
    patterns: tuple[TracedPattern, ...]
    dofs: tuple[str, ...]
    ticks: tuple[TracedTick, ...]


class TracedCondition(Wire):
    """A sensor condition of the current packet as of its last tick. `words` continue "the robot ...".

    `when` is before, maintain or after; `holds` is None if the condition's sensors are off.
    """

    when: str
    words: str
    holds: bool | None = None


class TraceReport(Wire):
    """Robot to service: the answer to a trace query, oldest first, only ticks with an active packet (inform)."""

    kind: Literal["trace_report"] = "trace_report"
    at_s: float
    stretches: tuple[TracedStretch, ...] = ()
    conditions: tuple[TracedCondition, ...] = ()


class MindQuery(Wire):
    """Service to robot: tell what you believe and are committed to (query)."""

    kind: Literal["mind_query"] = "mind_query"


class ToldBelief(Wire):
    """A belief. `value`: False if `term` is believed not to hold.

    `origin`: initial, adopted, perceptor or event; `source`: the rule or perceptor; `words`: what was perceived.
    """

    term: str
    value: bool
    origin: str
    source: str = ""
    words: str = ""
    since_s: float


class ToldCommitment(Wire):
    """A commitment, which is made each time a rule fires.

    `rule`: its file and line, "guard:3"; `bindings`: of the rule's variables; `made_s`: when it fired; `due_s`: when it
    becomes active; `state`: adopted, active, fulfilled, failed or dropped; `reason`: why it was dropped (condition,
    replaced, order, rules or overflow); `words`: why it failed or was dropped, for people.
    """

    number: int
    rule: str
    name: str
    towards: str
    bindings: dict[str, str] = Field(default_factory=dict, max_length=MAX_TOLD_BINDINGS)
    made_s: float
    due_s: float
    ended_s: float | None = None
    state: str
    reason: str | None = None
    words: str = ""


class ToldAgent(Wire):
    """One of the robot's agents. Beliefs are the newest, commitments those under way and then the last ended.

    `roles`: those that it plays; `belief_count`, `commitment_count`: how many it has, also those left out.
    """

    name: str
    roles: tuple[str, ...] = ()
    beliefs: tuple[ToldBelief, ...] = ()
    belief_count: int = 0
    commitments: tuple[ToldCommitment, ...] = ()
    commitment_count: int = 0


class ToldConversation(Wire):
    """An open conversation. `is_mine`: the robot has opened it; `reply_by_s`: until when it awaits an answer."""

    id: str
    protocol: str
    partner: str
    state: str
    is_mine: bool
    reply_by_s: float | None = None


class ToldMessage(Wire):
    """What was said to the robot and nothing but its rules may take. `content`: as in a rule file."""

    at_s: float
    performative: str
    sender: str
    content: str


class MindReport(Wire):
    """Robot to service: the answer to a mind query (inform). Times are the world's clock.

    `agents`: in order of rank, none without rules; `version`: of the rules that were sent last; `digests`: of the files
    that are followed, by name; `heard`: what rules have heard last, or would have heard, oldest first (null: older
    software does not tell).
    """

    kind: Literal["mind_report"] = "mind_report"
    at_s: float
    version: int = 0
    digests: dict[str, str] = Field(default_factory=dict)
    agents: tuple[ToldAgent, ...] = ()
    conversations: tuple[ToldConversation, ...] = ()
    heard: tuple[ToldMessage, ...] | None = None
