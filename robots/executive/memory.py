"""A robot's persistent memory: the state that it restores after a power failure.

It has two parts: the agent's mind, which may go on in another body, and what belongs to the body. Kept: the current
script with its progress, states of earlier scripts, answers, reports without a receipt, the tuning, rules, the pose
estimate. Not kept: sightings, tracked objects, the grid of its surroundings, the trace, sensors' defects, which show
again. All is JSON data.
"""

from collections.abc import Mapping
from typing import Any

from pydantic import ConfigDict, Field, model_validator

from robots.contract.memory import MailboxMemory, SocialMemory, StaleMemory
from robots.data import Checked, Memory
from robots.executive.embodiment import EmbodimentMemory
from robots.executive.mind_memory import MindMemory
from robots.perception.localisation import EstimateMemory
from robots.perception.progress import WayMemory
from robots.reactive.stall import StallMemory
from robots.wire import BehaviourScript, Factsheet, FailureCategory, PacketState, ScriptState
from robots.wire.operator import PacketTunings


class PacketMemory(Memory):
    """The progress of one packet. `told`: the sensors whose defects were reported; `held_s`: when each event's
    conditions last held, in the packet's time; `captures`: it has only its images left to take; `said_by`: by action
    that it waits for, the robots that have said to have ended it; `done_by`: the robot that has done it in this one's
    stead, empty if none has; `has_begun`: its patterns have acted.
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
    done_by: str = ""
    has_begun: bool = False


class DelegatedMemory(Checked):
    """The leg that is put to other robots, and how its packet has failed."""

    leg: str
    category: FailureCategory | None = None
    detail: str = ""


class ScriptMemory(Checked):
    """A script, the index of its current packet, the state of each packet, the newest order's number (0: none), and the
    leg that is put to other robots now.

    Fields of earlier versions are ignored.
    """

    model_config = ConfigDict(extra="ignore")
    script: BehaviourScript
    index: int = Field(ge=0)
    packets: tuple[PacketMemory, ...]
    order: int = Field(default=0, ge=0)
    delegated: DelegatedMemory | None = None


class NewsMemory(Checked):
    """A new state of a packet, or a script's end if `tag` is empty, that rules have not taken yet."""

    tag: str
    state: PacketState | ScriptState
    events: tuple[str, ...] = ()


class OwnMemory(Checked):
    """Own packets between those of the script: which of them runs, the progress of each, and how long they may last."""

    script: BehaviourScript
    index: int = Field(ge=0)
    packets: tuple[PacketMemory, ...]
    left_s: float


class SteeringMemory(Checked):
    """What rules have made of the current script: for how long it stays suspended at most, None if it is not; how often
    packets were begun again, by their ids; how long those that have finished have acted, by tag; why the last script,
    and the last own packets between a script's, have ended; what rules have not taken yet; and own packets that run.
    """

    suspended_s: float | None = None
    begun_again: dict[str, int] = Field(default_factory=dict)
    lasted_s: dict[str, tuple[float, ...]] = Field(default_factory=dict)
    end_reason: str = ""
    own_reason: str = ""
    news: tuple[NewsMemory, ...] = ()
    own: OwnMemory | None = None


class ExecutiveMemory(Checked):
    """The current script or the last one, and the states of the remembered ones, oldest first.

    `steering`: of a mind that is handed over to another program; None after a power failure, which ends commitments.
    """

    script: ScriptMemory | None = None
    states: dict[str, ScriptState] = Field(default_factory=dict)
    steering: SteeringMemory | None = None


class UpkeepMemory(Memory):
    """How often the robot has sought its charger, and when it last started; None if never."""

    count: int = 0
    began_s: float | None = None


class AgentMind(Checked):
    """What belongs to the agent and not to its body: it goes on with this in any body that can do what it needs.

    `executive`: the script with its place in it; `upkeep`: its own scripts' ids count on by it; `verdicts`: script id
    to the reason of its refusal, None if it was accepted; `stale`: scripts that are not accepted any longer; `mailbox`:
    answers to the service, and reports without a receipt; `social`: what is still to be said to other robots; `tuning`:
    of packets; `rules`: of the deliberative level with the role and what was adopted and retracted, None without one;
    `embodiment`: whether it rests, or until when it may act. Ids of scripts and messages are part of it, so that
    nothing is done or told twice in another body.
    """

    executive: ExecutiveMemory
    upkeep: UpkeepMemory
    verdicts: dict[str, str | None]
    stale: StaleMemory
    mailbox: MailboxMemory
    social: SocialMemory = SocialMemory()
    tuning_version: int
    tuning: PacketTunings
    rules: MindMemory | None = None
    embodiment: EmbodimentMemory = EmbodimentMemory()


class BodyMemory(Checked):
    """What belongs to the body: where it believes to be, what it holds, the energy of its sensors.

    `held`: what the jaws held when they were sensed last; `announced`: the last factsheet, which says what the body is.
    """

    estimate: EstimateMemory
    held: str | None = None
    sensing_used_j: float
    sensing_saved_j: float
    announced: Factsheet | None = None


class RobotMemory(Checked):
    """The whole memory. `body`: None for a mind that begins in a body that it was not in before.

    Memories of earlier versions, which did not tell the two apart, are read as well.
    """

    mind: AgentMind
    body: BodyMemory | None = None

    @model_validator(mode="before")
    @classmethod
    def _read_earlier(cls, data: Any) -> Any:
        if not isinstance(data, Mapping) or "executive" not in data:
            return data
        stated = {**data, "rules": data.get("mind")}
        return {
            part: {name: stated[name] for name in fields if name in stated}
            for part, fields in (("mind", AgentMind.model_fields), ("body", BodyMemory.model_fields))
        }
