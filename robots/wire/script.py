"""Behaviour scripts as they travel to a robot (MACTA §3-§4, fig. 3).

A packet on the wire is what the reflective agent may know: a tag, arguments and symbolic conditions. The robot's own
repertoire turns it into the triplet [sensor pre-conditions, behaviour patterns, sensor post-conditions].
"""

from math import isfinite
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field

from robots.data import Checked, StrEnum


def _finite(value: Any) -> Any:
    """The value of an unknown field, as JSON can hold it."""
    if isinstance(value, float) and not isfinite(value):
        raise ValueError("numbers are finite")
    for part in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        _finite(part)
    return value


class Wire(Checked):
    """Base of everything on the wire. Unknown fields are kept and passed on: the other end may be newer."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Annotated[Any, AfterValidator(_finite)]] = Field(init=False)


class SymbolicFact(Wire):
    """A ground fact in rel/ref form, as the API shows it: `in(sample_3, bay_7)`, `near(yard_1, door_1)`."""

    predicate: str
    args: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.args)})"


class PacketState(StrEnum):
    """The life of a packet on the robot (VDA 5050 action states)."""

    WAITING = "waiting"
    INITIALIZING = "initializing"  # started, its sensor pre-conditions are not met yet
    RUNNING = "running"
    PAUSED = "paused"
    RETRIABLE = "retriable"
    FINISHED = "finished"
    FAILED = "failed"


class ScriptState(StrEnum):
    """The state of a script on its robot."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    PAUSED = "paused"
    FINISHED = "finished"
    FAILED = "failed"
    CANCELLED = "cancelled"

    __hash__ = str.__hash__  # Enum's own is written in Python, and slow


class FailureCategory(StrEnum):
    """Why a mission or script failed."""

    ROBOT = "robot"
    DEADLINE = "deadline"
    UNREACHABLE = "unreachable"
    WORLD_CHANGED = "world_changed"
    CANCELLED = "cancelled"
    INTERNAL = "internal"


class Recipient(Wire):
    """A robot that waits for an action, by which script, and for how long at most."""

    robot: str
    script_id: str
    within_s: float = Field(gt=0)


class BehaviourPacket(Wire):
    """One step of a script.

    `arguments` name the plan-net action's parameters (table 3): {"object": "sample_1", "ref1": ..., "ref2": ...}.
    `requires` are the conditions of the plan-net action, `awaits` those of them that another robot brings about and
    this robot must therefore sense before it starts; `after` are the ids of actions that must have ended, which it
    cannot sense: it waits for a `Clearance` that names them; `achieves` are the linking goals.
    `told_by` are, by such an action, the robots that say to each other when they have ended it: once all of them have
    told this one, that is the clearance. `tells` are the robots to be told of this packet's end.
    `instead_of` are other packets of the robot that achieve the same, `because` the facts about the robot and the place
    that decided for this one. `events` are facts that hold once the packet has raised an event, by its name.
    """

    id: str
    tag: str
    arguments: dict[str, str]
    requires: tuple[SymbolicFact, ...] = ()
    awaits: tuple[SymbolicFact, ...] = ()
    after: tuple[str, ...] = ()
    told_by: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    tells: tuple[Recipient, ...] = ()
    achieves: tuple[SymbolicFact, ...] = ()
    expected_start_s: float = Field(ge=0, description="seconds after the mission's start")
    expected_duration_s: float = Field(gt=0)
    timeout_s: float = Field(gt=0, description="time the patterns may run once started")
    wait_timeout_s: float = Field(gt=0, description="time it may wait for its pre-conditions and clearance")
    description: str = ""
    instead_of: tuple[str, ...] = ()
    because: tuple[SymbolicFact, ...] = ()
    events: dict[str, tuple[SymbolicFact, ...]] = Field(default_factory=dict)
    tuning: dict[str, dict[str, float]] = Field(
        default_factory=dict,
        description="behaviour patterns' parameters to override, by pattern and parameter",
    )


class DelegableLeg(Wire):
    """Packets of a script, in a row, that another robot may do in this one's stead once one of them has failed.

    Whoever does them holds nothing at their beginning and end, and begins where it stands. `robots`: who may.
    """

    id: str
    packets: tuple[str, ...] = Field(min_length=1)
    robots: tuple[str, ...] = Field(min_length=1)


OWN = "own"
"""The mission of a script that a robot made itself."""
SAID = f"{OWN}:said:"
"""Begins the ids of scripts of a robot's own that persons have asked for."""


class BehaviourScript(Wire):
    """What one robot is to do for one mission, in order; a script of a later revision of the mission supersedes it.

    `delegable`: the legs that its robot may put to other robots while the service is out of reach; left out: none.
    """

    id: str
    mission_id: str
    robot: str
    revision: int = Field(default=0, ge=0)
    packets: tuple[BehaviourPacket, ...] = Field(min_length=1)
    delegable: tuple[DelegableLeg, ...] = ()

    @property
    def is_own(self) -> bool:
        """True if the robot made it itself."""
        return self.mission_id == OWN

    @property
    def is_for_person(self) -> bool:
        """True if it made it itself at a person's word."""
        return self.is_own and self.id.startswith(SAID)
