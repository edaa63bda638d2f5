"""A robot's flash memory: what it must not forget when its power fails, and how it goes on where it stood.

Kept: the script under way and the place in it, how earlier ones ended, answers given, reports without a receipt, the
tuning in use, the pose estimate. Not kept, for it senses anew: what it saw and tracked, the grid of its surroundings,
its trace. Data of the wire types: JSON can hold it.
"""

from pydantic import Field

from robots.physical.body import Pose
from robots.wire import BehaviourScript, Message, PacketState, ScriptState, SymbolicFact
from robots.wire.retuning import PacketTunings
from robots.wire.script import Wire


class StallMemory(Wire):
    """How far a packet's patience has come; seconds and metres. `best_m` is None before there is any."""

    retries: int = 0
    idle_s: float = 0.0
    manoeuvre_s: float | None = None
    best_m: float | None = None


class WayMemory(Wire):
    """What a packet's odometer has added up."""

    elapsed_s: float = 0.0
    travelled_m: float = 0.0
    advanced_m: float = 0.0
    turned_rad: float = 0.0


class PacketMemory(Wire):
    """How far one packet is. `held_s`: when, in the packet's time, each event's conditions last held."""

    state: PacketState
    uncleared: frozenset[str] = frozenset()
    waited_s: float = 0.0
    lost_s: float = 0.0
    unseen_s: float = 0.0
    told: frozenset[str] = frozenset()
    stall: StallMemory = StallMemory()
    way: WayMemory = WayMemory()
    raised: frozenset[str] = frozenset()
    held_s: dict[str, float] = Field(default_factory=dict)


class ScriptMemory(Wire):
    """A script, the index of its packet under way, how far each packet is, the newest order's number (0: none)."""

    script: BehaviourScript
    index: int = Field(ge=0)
    packets: tuple[PacketMemory, ...]
    task_state: frozenset[SymbolicFact] = frozenset()
    order: int = Field(default=0, ge=0)


class ExecutiveMemory(Wire):
    """The script under way or the last one, and the states of all that are remembered, oldest first."""

    script: ScriptMemory | None = None
    states: dict[str, ScriptState] = Field(default_factory=dict)


class MailboxMemory(Wire):
    """Answers given, each to the request that it names, and reports without a receipt; oldest first."""

    answers: tuple[Message, ...] = ()
    reports: tuple[Message, ...] = ()


class EstimateMemory(Wire):
    """Where the robot believes it is: `covariance` row by row of x, y, heading; `odometry` as last read."""

    pose: Pose
    covariance: tuple[float, ...] = Field(min_length=9, max_length=9)
    odometry: Pose | None
    rejected: int


class UpkeepMemory(Wire):
    """How often the robot has sought its charger, and when last; None if never."""

    count: int = 0
    began_s: float | None = None


class StaleMemory(Wire):
    """Scripts that were cancelled before they came, and the newest revision heard of missions; oldest first."""

    cancelled: tuple[str, ...] = ()
    revisions: dict[str, int] = Field(default_factory=dict)


class RobotMemory(Wire):
    """Everything. `verdicts`: why a script was refused, None for one that was agreed to, by its id."""

    mailbox: MailboxMemory
    executive: ExecutiveMemory
    verdicts: dict[str, str | None]
    stale: StaleMemory
    tuning_version: int
    tuning: PacketTunings
    estimate: EstimateMemory
    upkeep: UpkeepMemory
    sensing_used_j: float
    sensing_saved_j: float
