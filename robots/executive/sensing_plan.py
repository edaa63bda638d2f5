"""A plan as a finite state machine whose states run sensor actions beside actuator actions (P-SMPA, algorithm 2)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from robots.errors import RepertoireError
from robots.executive.actions import ActuatorAction, SensorAction, TaskPlan
from robots.physical.body import Sensor


@dataclass(frozen=True, slots=True)
class BehaviourState:
    """δ, or δ' if sensor actions run beside it: they end as soon as the actuator action does."""

    action: ActuatorAction
    beside: tuple[SensorAction, ...] = ()


@dataclass(frozen=True, slots=True)
class StateMachine:
    """f(Λ, T): behaviour states by their action's name, and which may follow which."""

    states: Mapping[str, BehaviourState] = field(default_factory=dict)
    transitions: frozenset[tuple[str, str]] = frozenset()

    @property
    def pre(self) -> frozenset[Sensor]:
        """The sensors that its sensor actions ask the body to be fitted with."""
        sensors: frozenset[Sensor] = frozenset()
        return sensors.union(*(s.pre for state in self.states.values() for s in state.beside))


def schedule(plan: TaskPlan, sensor_actions: Iterable[SensorAction]) -> StateMachine:
    """Algorithm 2: a state an action in the body's order; beside it the sensor actions with per(s) ⊆ pre(a).

    :raises RepertoireError: if two actions go by one name.
    """
    offered = tuple(sensor_actions)
    actions = (*plan.body, *plan.recoveries.values())
    states = {
        action.name: BehaviourState(action, tuple(s for s in offered if s.per <= action.percepts))
        for action in actions
    }
    if len(states) < len(actions):
        raise RepertoireError(f"two packets of {plan.invocation} go by one id")
    names = [action.name for action in plan.body]
    there = {(name, recovery.name) for name, recovery in plan.recoveries.items()}
    back = {(after, before) for before, after in there}
    return StateMachine(states, frozenset({*pairwise(names), *there, *back}))
