"""A robot's flash memory: what it must not forget when its power fails, and how it goes on where it stood.

Kept: the script under way and the place in it, how earlier ones ended, answers given, reports without a receipt, the
tuning in use, the pose estimate. Not kept, for it senses anew: what it saw and tracked, the grid of its surroundings,
its trace. Data of the wire types: JSON can hold it.
"""

from pydantic import ConfigDict, Field

from robots.data import Checked
from robots.perception.localisation import EstimateMemory
from robots.perception.progress import WayMemory
from robots.reactive.stall import StallMemory
from robots.wire import BehaviourScript, Message, PacketState, ScriptState
from robots.wire.operator import PacketTunings


class PacketMemory(Checked):
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


class ScriptMemory(Checked):
    """A script, the index of its current packet, the state of each packet, the newest order's number (0: none).

    Fields of earlier versions are ignored.
    """

    model_config = ConfigDict(extra="ignore")
    script: BehaviourScript
    index: int = Field(ge=0)
    packets: tuple[PacketMemory, ...]
    order: int = Field(default=0, ge=0)


class ExecutiveMemory(Checked):
    """The script under way or the last one, and the states of all that are remembered, oldest first."""

    script: ScriptMemory | None = None
    states: dict[str, ScriptState] = Field(default_factory=dict)


class MailboxMemory(Checked):
    """Answers given, each to the request that it names, and reports without a receipt; oldest first."""

    answers: tuple[Message, ...] = ()
    reports: tuple[Message, ...] = ()


class UpkeepMemory(Checked):
    """How often the robot has sought its charger, and when last; None if never."""

    count: int = 0
    began_s: float | None = None


class StaleMemory(Checked):
    """Scripts that were cancelled before they came, and the newest revision heard of missions; oldest first."""

    cancelled: tuple[str, ...] = ()
    revisions: dict[str, int] = Field(default_factory=dict)


class RobotMemory(Checked):
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
