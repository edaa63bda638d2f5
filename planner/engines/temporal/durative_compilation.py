"""A planning problem in unified-planning's form with durative actions, for engines that schedule themselves.

Conditions hold from an action's start to its end unless it deletes them, deletes happen at its start, effects
at its end: the plan-net's own semantics. Time is counted in tenths of a second, in whole numbers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from planner.interchange.compilation import UNIFIED_PLANNING_LOCK, CompiledProblem, Compiler
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.extraction import fault_of
from planner.problem.interface import PlanningProblem


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A step of an engine's schedule: operator and objects as named in the compiled problem, in its time."""

    start: float
    duration: float
    operator: str
    objects: tuple[str, ...]


def compile_temporal(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> CompiledProblem:
    """The problem in unified-planning's form: lifted, typed, durative, to be over soon."""
    with UNIFIED_PLANNING_LOCK:
        up_problem = _TemporalCompiler(knowledge_base, problem).run()
    return CompiledProblem(knowledge_base=knowledge_base, problem=problem, up_problem=up_problem)


def sequence_of(compiled: CompiledProblem, schedule: Sequence[Step]) -> tuple[GroundAction, ...]:
    """The schedule as a sequence that reaches the goals: by start or, where those overlap too much, by end.

    :raises InvalidPlan: if a step is of no operator.
    """
    problem = compiled.problem
    orders = (
        sorted(schedule, key=lambda step: (step.start, step.start + step.duration)),
        sorted(schedule, key=lambda step: (step.start + step.duration, step.start)),
    )
    sequences = [tuple(compiled.ground(step.operator, step.objects) for step in order) for order in orders]
    good = (one for one in sequences if fault_of(one, problem.facts, problem.goals) is None)
    return next(good, sequences[0])


class _TemporalCompiler(Compiler):
    """Builds one unified-planning problem of durative actions."""

    def _new_action(self, name: str, parameters: Mapping[str, Any]) -> Any:
        from unified_planning.model import DurativeAction

        return DurativeAction(name, _env=self._environment, **parameters)

    def _need(self, action: Any, condition: Any, *, lasting: bool) -> None:
        from unified_planning.model import ClosedTimeInterval, EndTiming, StartTiming

        start = StartTiming()
        end = EndTiming()
        action.add_condition(ClosedTimeInterval(start, end) if lasting else start, condition)

    def _delete(self, action: Any, fluent: Any, *, restored: bool) -> None:
        from unified_planning.model import StartTiming

        action.add_effect(StartTiming(), fluent, False)

    def _add(self, action: Any, fluent: Any) -> None:
        from unified_planning.model import EndTiming

        action.add_effect(EndTiming(), fluent, True)

    def _minimise(self, costs: Mapping[Any, Any]) -> None:
        from unified_planning.model.metrics import MinimizeMakespan

        for action, duration in costs.items():
            action.set_fixed_duration(duration)
        self._up.add_quality_metric(MinimizeMakespan(environment=self._environment))
