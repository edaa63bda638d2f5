"""The formal model's actions and plans (P-SMPA §4.2): S of sensor actions, A of actuator actions, P of plans."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from robots.conditions import Condition
from robots.perception.percepts import NOTHING, Needs
from robots.physical.body import ALL_SENSORS, Sensor
from robots.reactive.patterns import BehaviourPattern
from robots.wire import SymbolicFact


class Mode(StrEnum):
    """Cyclic sensors read on and on, one-shot ones once (P-SMPA §4.1, multi-mode)."""

    CYCLIC = "cyclic"
    ONE_SHOT = "one_shot"


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorAction:
    """s = ⟨pre(s), per(s)⟩. Our choice: a percept goes by its sensor's name.

    `pre`: the sensors the body must be fitted with.
    """

    sensor: Sensor
    mode: Mode = Mode.CYCLIC

    @property
    def pre(self) -> frozenset[Sensor]:
        return frozenset({self.sensor})

    @property
    def per(self) -> frozenset[Sensor]:
        return frozenset({self.sensor})


CYCLIC_ACTIONS = tuple(SensorAction(sensor=sensor) for sensor in sorted(ALL_SENSORS))


@dataclass(frozen=True, slots=True, kw_only=True)
class ActuatorAction:
    """a = ⟨pre(a), add(a), del(a)⟩. `percepts` are those that pre(a) and the action's patterns ask for."""

    name: str
    percepts: Needs
    pre: tuple[Condition, ...] = ()
    add: frozenset[SymbolicFact] = frozenset()
    delete: frozenset[SymbolicFact] = frozenset()

    def apply(self, state: frozenset[SymbolicFact]) -> frozenset[SymbolicFact]:
        """τ' = add(a) ∪ (τ \\ del(a))."""
        return self.add | (state - self.delete)


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskPlan:
    """p = ⟨t(p), c(p), bd(p)⟩: what invokes it, the context it applies in, its body in order.

    Our addition: `recoveries`, the action that an action of the body, by name, gives way to until it can go on.
    """

    invocation: str
    context: tuple[Condition, ...]
    body: tuple[ActuatorAction, ...]
    recoveries: Mapping[str, ActuatorAction] = field(default_factory=dict)


def percepts_of(conditions: Iterable[Condition] = (), patterns: Iterable[BehaviourPattern] = ()) -> Needs:
    """What conditions and patterns ask for, by the declarations of the words they are made of."""
    needed: list[Needs] = [condition.needs for condition in conditions]
    for pattern in patterns:
        needed += [pattern.stimulus.needs, *(condition.needs for condition in pattern.when)]
    return NOTHING.union(*needed)


def superseded(requires: Iterable[SymbolicFact], achieves: Iterable[SymbolicFact]) -> frozenset[SymbolicFact]:
    """del(a) of a packet: what it required of a thing that it makes otherwise.

    Our choice, for the robot has no knowledge base: a thing is in one place, a robot near one, an attribute has
    one value; so a fact gives way to another that differs in its last argument alone.
    """
    changed = {(fact.predicate, fact.args[:-1]) for fact in achieves if len(fact.args) > 1}
    return frozenset(
        fact for fact in requires if len(fact.args) > 1 and (fact.predicate, fact.args[:-1]) in changed
    ) - frozenset(achieves)
