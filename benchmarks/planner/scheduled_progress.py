"""How far a plan-net has been carried out at a time if everything goes as scheduled."""

from dataclasses import replace

from planner import Fact, PlanNet, PlanningProblem
from planner.repair import NOT_BEGUN, MissionProgress


def as_scheduled(
    plan_net: PlanNet, facts: frozenset[Fact], elapsed_s: float
) -> tuple[frozenset[Fact], MissionProgress]:
    """The facts and the progress so long after the start, if everything goes as scheduled."""
    state = set(facts)
    done = set[str]()
    under_way = dict[str, float]()
    starts = [(action.earliest_start_s, 1, action) for action in plan_net.actions]
    ends = [(action.earliest_end_s, 0, action) for action in plan_net.actions]
    for _, begins, action in sorted([*starts, *ends], key=lambda event: event[:2]):
        if begins and action.earliest_start_s < elapsed_s:
            state.difference_update(action.deletes)
            under_way[action.id] = round(action.earliest_end_s - elapsed_s, 3)
        elif not begins and action.earliest_end_s <= elapsed_s:
            state.update(action.effects)
            done.add(action.id)
            del under_way[action.id]
    return frozenset(state), MissionProgress(done=frozenset(done), under_way=under_way, elapsed_s=elapsed_s)


def after(plan: PlanNet, problem: PlanningProblem, share: float) -> tuple[PlanningProblem, MissionProgress]:
    """A plan's problem once so much of its time is over and all that has begun has ended, and how far the plan is."""
    if not share:
        return problem, NOT_BEGUN
    elapsed_s = min(
        one.earliest_end_s for one in plan.actions if one.earliest_end_s >= share * plan.makespan_s
    )
    facts, progress = as_scheduled(plan, problem.facts, elapsed_s)
    done = progress.done.union(progress.under_way)
    brought = {fact for name in progress.under_way for fact in plan.action(name).effects}
    return replace(problem, facts=facts | brought), MissionProgress(done=done, elapsed_s=elapsed_s)
