"""Plans goals in stages: each stage from where the one before ends, its goals added to those achieved already."""

from collections.abc import Sequence
from dataclasses import replace

from planner.engines.plan_net_completion import Outcome, complete_plan_net, timed_result
from planner.engines.wrapping import WrappingEngine
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.progression import progressed
from planner.plan_nets.stages import goals_by_stage
from planner.plan_nets.validation import sequence_of
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts


class StagedEngine(WrappingEngine):
    """An engine that also takes goals in stages; without stages it answers as the engine does.

    NOTE: a stage's plan is chosen without regard to the later ones. That a later stage has no plan is therefore no
    proof that there is none, and there is no lower bound of the whole.
    """

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        stages = goals_by_stage(problem.goals, problem.stages)
        whole = replace(problem, stages={})
        if len(stages) <= 1:
            return self._engine.plan(whole, request, observer)
        return timed_result(
            self.name,
            self._base,
            problem,
            request,
            lambda: planned_in_stages(
                problem, stages, TimeLimitedEngine(self._engine, request, observer), self._base
            ),
        )


def planned_in_stages(
    problem: PlanningProblem,
    stages: Sequence[tuple[Fact, ...]],
    planner: TimeLimitedEngine,
    knowledge_base: KnowledgeBase,
) -> Outcome:
    """The problem's plan-net from plans for the goals up to each stage, each made from where the one before ends.

    :param stages: they need not be those of the problem; of these alone the plan-net has the orderings.
    """
    facts = problem.facts
    elapsed_s = 0.0
    sequence: list[GroundAction] = []
    for number, goals in enumerate(stages):
        left = {goal: due_s - elapsed_s for goal, due_s in problem.deadlines_s.items() if goal in goals}
        later = {goal: start_s - elapsed_s for goal, start_s in problem.not_before_s.items() if goal in goals}
        stage = replace(problem, facts=facts, goals=goals, deadlines_s=left, not_before_s=later, stages={})
        result = planner.plan(stage)
        if result.plan_net is None:
            return _unplanned(result, stages, number)
        actions = sequence_of(result.plan_net)
        sequence.extend(actions)
        facts = progressed(facts, actions)
        elapsed_s += result.plan_net.makespan_s
    planned = complete_plan_net(sequence, problem, knowledge_base, StaticFacts(knowledge_base, problem))
    if isinstance(planned, str):
        return PlanningStatus.NOT_FOUND, None, planned
    return PlanningStatus.SOLVED, planned, ""


def _unplanned(result: PlanningResult, stages: Sequence[tuple[Fact, ...]], number: int) -> Outcome:
    """The outcome if a stage has no plan. Only of the first stage that is a proof."""
    if number == 0:
        return result.status, None, result.reason
    status = PlanningStatus.NOT_FOUND if result.status is PlanningStatus.UNSOLVABLE else result.status
    before = ", ".join(map(str, stages[number - 1]))
    return status, None, f"after {before}: {result.reason or result.status.value}"
