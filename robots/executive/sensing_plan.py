"""Which sensor actions run beside each actuator action of a script (P-SMPA §5.1, algorithm 2).

A packet is up to four actuator actions: it waits for its pre-conditions, acts, retries after a stall, and stands while
it takes images. The sensor actions run whose percepts the current actuator action needs, and end with it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from robots.conditions.facts import REPORTED
from robots.conditions.verdict import Condition
from robots.data import StrEnum
from robots.errors import RepertoireError
from robots.perception.percepts import NOTHING, Needs
from robots.perception.sensing import Mode, SensorAction
from robots.reactive.patterns import BehaviourPattern
from robots.reactive.stall import WATCHED
from robots.repertoire import BoundPacket
from robots.wire import BehaviourScript


class Phase(StrEnum):
    """The actuator actions of a packet."""

    WAIT = "wait"
    """Until its pre-conditions hold."""
    ACT = "act"
    """Until its post-conditions hold."""
    RETRY = "retry"
    """The retry manoeuvre after a stall."""
    CAPTURE = "capture"
    """Its post-conditions have held: it stands until its cameras have taken their images."""

    __hash__ = str.__hash__  # as of sensors, to be looked up quickly


@dataclass(frozen=True, slots=True)
class BehaviourState:
    """A state of the script's state machine: one phase of one packet, and the sensors whose percepts it needs.

    `cameras`: those of them that read once.
    """

    needs: Needs
    cameras: Needs = NOTHING
    beside: tuple[SensorAction, ...] = field(init=False)
    """The sensor actions that run beside the actuator action: those with per(s) in pre(a)."""

    def __post_init__(self) -> None:
        beside = tuple(
            SensorAction(sensor=sensor, mode=Mode.ONE_SHOT if sensor in self.cameras else Mode.CYCLIC)
            for sensor in sorted(self.needs)
        )
        object.__setattr__(self, "beside", beside)


StateMachine = Mapping[tuple[str, Phase], BehaviourState]
"""By packet id and phase."""


def schedule(script: BehaviourScript, contents: Sequence[BoundPacket]) -> StateMachine:
    """The states of a script; `contents` are its packets' contents in order.

    :raises RepertoireError: if two packets have one id.
    """
    states: dict[tuple[str, Phase], BehaviourState] = {}
    for packet, content in zip(script.packets, contents, strict=True):
        if (packet.id, Phase.WAIT) in states:
            raise RepertoireError(f"two packets of {script.id} have one id: {packet.id}")
        acting = _needs_of_acting(content)
        waiting = REPORTED | needs_of(content.before, content.waiting)
        states[packet.id, Phase.WAIT] = BehaviourState(waiting)
        states[packet.id, Phase.ACT] = BehaviourState(acting)
        states[packet.id, Phase.RETRY] = BehaviourState(acting | needs_of(patterns=content.retry))
        states[packet.id, Phase.CAPTURE] = BehaviourState(acting | content.cameras, content.cameras)
    return states


def needs_of(conditions: Iterable[Condition] = (), patterns: Iterable[BehaviourPattern] = ()) -> Needs:
    """The sensors that conditions and patterns declare."""
    needed: list[Needs] = [condition.needs for condition in conditions]
    for pattern in patterns:
        needed += [pattern.stimulus.needs, *(condition.needs for condition in pattern.when)]
    return NOTHING.union(*needed)


def _needs_of_acting(content: BoundPacket) -> Needs:
    conditions = [*content.maintain, *content.after]
    conditions += [condition for event in content.events.values() for condition in event]
    avoiding = NOTHING if content.avoid is None else content.avoid.needs
    return REPORTED | WATCHED | avoiding | needs_of(conditions, content.patterns)
