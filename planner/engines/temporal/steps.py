"""The steps of a temporal planner's schedule."""

from collections.abc import Sequence
from dataclasses import dataclass

from planner.interchange.pddl import PddlTask
from planner.knowledge import GroundAction
from planner.plan_nets.extraction import fault_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A step of a schedule: operator and objects as the PDDL task names them, times in the engine's unit."""

    start: float
    duration: float
    operator: str
    objects: tuple[str, ...]


def sequence_of(task: PddlTask, schedule: Sequence[Step]) -> tuple[GroundAction, ...]:
    """The schedule as a sequence that reaches the goals: by start or, where those overlap too much, by end.

    :raises InvalidPlan: if a step is of no operator.
    """
    problem = task.problem
    orders = (
        sorted(schedule, key=lambda step: (step.start, step.start + step.duration)),
        sorted(schedule, key=lambda step: (step.start + step.duration, step.start)),
    )
    sequences = [tuple(task.ground(step.operator, step.objects) for step in order) for order in orders]
    good = (one for one in sequences if fault_of(one, problem.facts, problem.goals) is None)
    return next(good, sequences[0])
