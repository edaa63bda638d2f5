"""Messages between agent models and robots, with FIPA performatives.

A sender keeps every message but telemetry until a reply names it: a robot answers a request with agree or refuse, the
service answers a report with a receipt (`confirm`). Both ends ignore known ids and repeat their answer. A message of a
kind that the receiver does not know is answered with not-understood.
"""

import json
import uuid
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, field_validator, model_validator
from typing_extensions import Self

from robots.data import StrEnum
from robots.wire.delegation import DelegationReport
from robots.wire.embodiment import MindOrder, MindOrderReport, MindTransfer, MindTransferReport
from robots.wire.operator import (
    MindQuery,
    MindReport,
    Retune,
    RuleSet,
    RulesReport,
    SetPoint,
    SetPointRefusal,
    TraceQuery,
    TraceReport,
    TuningReport,
)
from robots.wire.results import PacketResult
from robots.wire.script import BehaviourScript, FailureCategory, PacketState, ScriptState, SymbolicFact, Wire
from robots.wire.speech import Performative, SpeechAct, SpeechReport

CONTRACT = "1.0"
"""The version of the contract: minor versions add fields and kinds, a major one may change them (docs/robots.md)."""
WORLD = "_world"
"""The world itself as sender and receiver; no robot can have this name."""
MAX_FACTSHEET_BYTES = 16 * 1024


class ControlVerb(StrEnum):
    """What an order asks of a script."""

    CANCEL = "cancel"
    PAUSE = "pause"
    RESUME = "resume"


class ScriptRequest(Wire):
    """Service to robot: carry out this script (request)."""

    kind: Literal["script_request"] = "script_request"
    script: BehaviourScript


class Control(Wire):
    """Service to robot: cancel, pause or resume the script (cancel or request).

    Of the orders on one script each has a greater `number` than those before it; 0 is an order without a number.
    """

    kind: Literal["control"] = "control"
    script_id: str
    verb: ControlVerb
    number: int = Field(default=0, ge=0)


class Clearance(Wire):
    """Service to robot: these actions, which packets of the script wait for, have ended (request).

    It names all that have ended so far, so that a lost or late clearance does no harm.
    """

    kind: Literal["clearance"] = "clearance"
    script_id: str
    ended: tuple[str, ...]


class StatusQuery(Wire):
    """Service to robot: report the state of this script (query)."""

    kind: Literal["status_query"] = "status_query"
    script_id: str


class Acknowledgement(Wire):
    """Robot to service: the request named by `in_reply_to` is accepted (agree)."""

    kind: Literal["acknowledgement"] = "acknowledgement"
    script_id: str


class Refusal(Wire):
    """Robot to service: the request named by `in_reply_to` is refused (refuse)."""

    kind: Literal["refusal"] = "refusal"
    script_id: str
    reason: str


class PacketReport(Wire):
    """Robot to service: a packet has changed its state or raised `events` (inform).

    `results`: what a packet that has finished brings beside its effects. `cleared_by`: of a packet that has begun, by
    action that it waited for, the robots that have said to have ended it (`BehaviourPacket.told_by`).
    """

    kind: Literal["packet_report"] = "packet_report"
    script_id: str
    packet_id: str
    state: PacketState
    at_s: float
    perceived: tuple[SymbolicFact, ...] = ()
    events: tuple[str, ...] = ()
    detail: str = ""
    results: tuple[PacketResult, ...] = Field(default=(), max_length=4)
    cleared_by: dict[str, tuple[str, ...]] = Field(default_factory=dict, max_length=256)


class ScriptReport(Wire):
    """Robot to service: the script ended (inform on success, failure otherwise).

    `done_by`: the packets that other robots have done in this one's stead, and which.
    """

    kind: Literal["script_report"] = "script_report"
    script_id: str
    state: ScriptState
    at_s: float
    packet_id: str | None = None
    category: FailureCategory | None = None
    perceived: tuple[SymbolicFact, ...] = ()
    detail: str = ""
    done_by: dict[str, str] = Field(default_factory=dict, max_length=256)


class UpkeepReport(Wire):
    """Robot to service: the state of a packet of its own script (inform).

    Without facts when it starts to drive somewhere. `driver`: the operator who drives the robot, None for upkeep.
    """

    kind: Literal["upkeep_report"] = "upkeep_report"
    tag: str
    state: PacketState
    at_s: float
    perceived: tuple[SymbolicFact, ...] = ()
    detail: str = ""
    driver: str | None = None


class FaultLevel(StrEnum):
    """How grave a fault of a robot is, as in VDA 5050 3.0."""

    WARNING = "warning"
    """The robot goes on."""
    URGENT = "urgent"
    """It goes on, but somebody should look after it."""
    CRITICAL = "critical"
    """It cannot go on with what it does, but with something else."""
    FATAL = "fatal"
    """It cannot go on until somebody intervenes."""


class RobotFault(Wire):
    """A fault in the robot's own words: they are shown, and nothing is decided by them."""

    level: FaultLevel
    type: str = Field(max_length=128)
    text: str = Field(default="", max_length=1024)


class FaultReport(Wire):
    """Robot to service: all faults that it has now, none once all are gone (inform). Sent when they have changed."""

    kind: Literal["fault_report"] = "fault_report"
    at_s: float
    faults: tuple[RobotFault, ...] = Field(max_length=32)


class SampleReport(Wire):
    """Robot to service: a sample that the robot was not told of lies in a place (inform)."""

    kind: Literal["sample_report"] = "sample_report"
    sample: str
    place: str
    at_s: float


class FactsheetState(StrEnum):
    """What has become of a robot's factsheet."""

    IN_FORCE = "in_force"
    """The robot is in the world as it says."""
    POSTPONED = "postponed"
    """A running mission needs what it changes; it is tried again later."""
    ANNOUNCED = "announced"
    """The world has no such robot; an operator may admit it."""
    REFUSED = "refused"
    """The robot cannot be in the world as it says, or an operator does not admit it."""


class Factsheet(Wire):
    """Robot to service: what the robot is (inform). A changed one has a greater `number`.

    `body` and `sensors` as in a world file, each a kind or one with its measures; `repertoire`: its packets' tags.
    `compartment`, `aisle`, `home`: the area and home that it keeps to; without a compartment, that in which it stands.
    `senses`: the predicates whose facts it perceives of others' work, such as `in` and `clear`; left out: what was
    said before of it, or none. What it does not perceive it is told by clearance. `speaks`: what it says to other
    robots and takes from them, such as `clearance`; left out: what was said before of it, or nothing.
    `start`: where it stands, x and y in metres, heading in degrees. `edition`: of the world that made it so; None for a
    robot that is not simulated. `contract`: the version that the robot was made for; empty if it does not say.
    `peripheral`: of a door, hatch or lift, all that a world file says of it but its name; speeds are left out then.
    """

    kind: Literal["factsheet"] = "factsheet"
    number: int = Field(default=0, ge=0, le=2**53)
    body: dict[str, Any] | str = "velocity"
    sensors: tuple[dict[str, Any] | str, ...] = Field(default=(), max_length=32)
    senses: tuple[str, ...] | None = Field(default=None, max_length=64)
    speaks: tuple[str, ...] | None = Field(default=None, max_length=16)
    repertoire: tuple[str, ...] = Field(max_length=256)
    speed_m_s: float = Field(default=0.0, ge=0)
    turn_rad_s: float = Field(default=0.0, ge=0)
    compartment: str | None = None
    aisle: str | None = None
    home: str | None = None
    start: tuple[float, float, float] | None = None
    edition: int | None = Field(default=None, ge=0)
    contract: str = ""
    peripheral: dict[str, Any] | None = None

    @property
    def content(self) -> "Factsheet":
        """What it says, without what tells one from another that says the same."""
        return self.model_copy(update={"number": 0, "edition": None, "start": None})

    @model_validator(mode="after")
    def _can_be_kept(self) -> Self:
        if self.peripheral is None and not (self.speed_m_s > 0 and self.turn_rad_s > 0):
            raise ValueError("the factsheet of a robot has speed_m_s and turn_rad_s, both greater than 0")
        text = json.dumps(self.model_dump(mode="python"), allow_nan=False)
        if len(text) > MAX_FACTSHEET_BYTES:
            raise ValueError(f"a factsheet of {len(text)} bytes; at most {MAX_FACTSHEET_BYTES} are taken")
        if "\\u" in text:
            raise ValueError("a factsheet has printable ASCII characters only")
        return self


class FactsheetAnswer(Wire):
    """Service to robot: what has become of its factsheet (confirm, or refuse with the reason)."""

    kind: Literal["factsheet_answer"] = "factsheet_answer"
    state: FactsheetState
    reason: str = ""


class StatusReport(Wire):
    """Robot to service: the answer to a status query (inform). `state` is None for a script it does not know.

    `order` is the number of the newest order that it has followed on the script, 0 if none.
    """

    kind: Literal["status_report"] = "status_report"
    script_id: str
    state: ScriptState | None
    at_s: float
    packet_id: str | None = None
    packet_state: PacketState | None = None
    perceived: tuple[SymbolicFact, ...] = ()
    detail: str = ""
    order: int = Field(default=0, ge=0)


class Receipt(Wire):
    """Service to robot: the report named by `in_reply_to` is recorded, forget it (confirm)."""

    kind: Literal["receipt"] = "receipt"


class Telemetry(Wire):
    """Robot to service, never kept or repeated (inform): its present state as it estimates it.

    `x_m, y_m, heading_rad` is its own estimate in the world's frame; `ranges_m` shape (N,), metres, beam 0 ahead,
    counter-clockwise, None where nothing is in range; `tags` places it sees samples at, in the world's frame;
    `patterns` the active behaviour patterns' (r, u) by "dof/name", normalised, `resultants` theirs by "dof"; `sensors`
    those that run; `sensing_j` the energy that sensors have used since the robot's start, `sensing_saved_j` what those
    that were off would have used; `degraded` readings that are left out, in words; `driven_by` the operator who drives
    the robot; `goal_m` the distance to the current packet's goal, None if that is not known; `touched` whether its
    bumper has touched something since the last telemetry, None if the bumper has not read since.
    """

    kind: Literal["telemetry"] = "telemetry"
    at_s: float
    x_m: float
    y_m: float
    heading_rad: float
    ranges_m: tuple[float | None, ...] = ()
    holding: str | None = None
    battery: float = 1.0
    charging: bool = False
    script_id: str | None = None
    script_state: ScriptState | None = None
    packet_id: str | None = None
    packet_tag: str | None = None
    packet_state: PacketState | None = None
    tags: dict[str, tuple[float, float]] = Field(default_factory=dict)
    patterns: dict[str, tuple[float, float]] = Field(default_factory=dict)
    resultants: dict[str, tuple[float, float]] = Field(default_factory=dict)
    sensors: tuple[str, ...] = ()
    sensing_j: float = 0.0
    sensing_saved_j: float = 0.0
    degraded: tuple[str, ...] = ()
    driven_by: str | None = None
    goal_m: float | None = None
    touched: bool | None = None


class WorldChange(Wire):
    """Service to a world: go on as this edition of it (request). `world` is the whole changed world file.

    `minds`: of robots that it simulates from then on in place of their own software, the texts of `MindDocument`. Such
    a mind rests until it is told to go on.
    """

    kind: Literal["world_change"] = "world_change"
    edition: int = Field(ge=1)
    world: dict[str, Any]
    minds: dict[str, str] = Field(default_factory=dict)


class MovedSample(Wire):
    """Where a robot that the world's fleet does not simulate has left a sample, or that it holds it (`place`)."""

    sample: str
    place: str
    at_s: float


class ForeignState(Wire):
    """Service to a world: what robots that it does not simulate have told (inform).

    It is the whole state, sent again and again; robots that are missing stand where they stood. `version` counts the
    changes of facts: one with a lower version is outdated. `robots`: their poses, x and y in metres and heading in
    radians. `samples`: those that such a robot was the last to move.
    """

    kind: Literal["foreign_state"] = "foreign_state"
    version: int = Field(ge=0)
    robots: dict[str, tuple[float, float, float]] = Field(default_factory=dict)
    samples: tuple[MovedSample, ...] = ()


class WorldEdition(Wire):
    """World to service: the edition that it is now at (agree), or why it refuses the one asked for (refuse)."""

    kind: Literal["world_edition"] = "world_edition"
    edition: int = Field(ge=0)
    reason: str = ""


class NotUnderstood(Wire):
    """To the sender of the message named by `in_reply_to`: its kind is not known here (not-understood).

    Such a message is answered once, and this answer never. The sender forgets its message, which is not acted on.
    """

    kind: Literal["not_understood"] = "not_understood"
    reason: str


KnownBody = Annotated[
    ScriptRequest
    | Control
    | Clearance
    | StatusQuery
    | Acknowledgement
    | Refusal
    | PacketReport
    | ScriptReport
    | StatusReport
    | UpkeepReport
    | FaultReport
    | SampleReport
    | Factsheet
    | FactsheetAnswer
    | TraceQuery
    | TraceReport
    | MindQuery
    | MindReport
    | Retune
    | TuningReport
    | RuleSet
    | RulesReport
    | MindOrder
    | MindOrderReport
    | MindTransfer
    | MindTransferReport
    | SetPoint
    | SetPointRefusal
    | Receipt
    | WorldChange
    | WorldEdition
    | ForeignState
    | NotUnderstood
    | SpeechAct
    | SpeechReport
    | DelegationReport
    | Telemetry,
    Field(discriminator="kind"),
]
"""The bodies that this version knows, each with a kind of its own."""
KINDS = frozenset(
    get_args(body.model_fields["kind"].annotation)[0] for body in get_args(get_args(KnownBody)[0])
)


class UnknownBody(Wire):
    """A body of a kind that this version does not know, with all its fields."""

    kind: str = Field(min_length=1, max_length=64)

    @field_validator("kind")
    @classmethod
    def _is_unknown(cls, kind: str) -> str:
        if kind in KINDS:
            raise ValueError(f"{kind} is a known kind")
        return kind


Body = Annotated[KnownBody | UnknownBody, Field(union_mode="left_to_right")]


def is_same_contract(version: str) -> bool:
    """True if both ends of that version and of this one understand each other; also if it is empty, not said."""
    return not version or version.partition(".")[0] == CONTRACT.partition(".")[0]


def new_message_id() -> str:
    return uuid.uuid4().hex


class Message(Wire):
    """One speech act. `sent_at_s` is the sender's clock; the service is called "service", a robot by its name."""

    id: str = Field(default_factory=new_message_id, min_length=1, max_length=120)
    performative: Performative
    sender: str
    receiver: str
    sent_at_s: float
    in_reply_to: str | None = None
    body: Body
