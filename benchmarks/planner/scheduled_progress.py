"""How far a plan-net has been carried out at a time if everything goes as scheduled."""

from planner import Fact, PlanNet
from planner.repair import MissionProgress


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
