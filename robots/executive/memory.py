"""A robot's persistent memory: the state that it restores after a power failure.

Kept: the current script with its progress, states of earlier scripts, answers, reports without a receipt, the tuning,
the pose estimate. Not kept: sightings, tracked objects, the grid of its surroundings, the trace. All is JSON data.
"""

from pydantic import ConfigDict, Field

from robots.contract.memory import MailboxMemory, SocialMemory, StaleMemory
from robots.data import Checked, Memory
from robots.executive.mind_memory import MindMemory
from robots.perception.localisation import EstimateMemory
from robots.perception.progress import WayMemory
from robots.reactive.stall import StallMemory
from robots.wire import BehaviourScript, Factsheet, PacketState, ScriptState
from robots.wire.operator import PacketTunings


class PacketMemory(Memory):
    """The progress of one packet. `told`: the sensors whose defects were reported; `held_s`: when each event's
    conditions last held, in the packet's time; `captures`: it has only its images left to take; `said_by`: by action
    that it waits for, the robots that have said to have ended it.
    """

    state: PacketState
    uncleared: frozenset[str] = frozenset()
    waited_s: float = 0.0
    lost_s: float = 0.0
    unseen_s: float = 0.0
    told: frozenset[str] = frozenset()
    stall: StallMemory = Field(default_factory=StallMemory)
    way: WayMemory = Field(default_factory=WayMemory)
    raised: frozenset[str] = frozenset()
    held_s: dict[str, float] = Field(default_factory=dict)
    captures: bool = False
    said_by: dict[str, frozenset[str]] = Field(default_factory=dict)


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
    """The current script or the last one, and the states of the remembered ones, oldest first."""

    script: ScriptMemory | None = None
    states: dict[str, ScriptState] = Field(default_factory=dict)


class UpkeepMemory(Memory):
    """How often the robot has sought its charger, and when it last started; None if never."""

    count: int = 0
    began_s: float | None = None


class RobotMemory(Checked):
    """The whole memory. `verdicts`: script id to the reason of its refusal, None if it was accepted; `announced`: the
    last factsheet; `social`: what it has still to say to other robots; `mind`: of the deliberative level, None without
    one.
    """

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
    held: str | None = None
    announced: Factsheet | None = None
    social: SocialMemory = SocialMemory()
    mind: MindMemory | None = None
