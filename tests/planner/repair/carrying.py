"""A small store whose plan is under way, ways in which the world changes under it, and what it comes to."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from planner import Fact, KnowledgeBase, PlanNet, PlanNetAction, PlanningProblem, faults_of
from planner.interchange.up_validation import up_fault
from planner.repair import Repair
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

STORE = Store()
SAMPLES = {"s0": "door_0", "s1": "door_1"}
GOALS = (inside("s0", "bay_0_0"), inside("s1", "bay_1_2"))


def problem(samples: Mapping[str, str] | None = None, goals: Iterable[Fact] = GOALS) -> PlanningProblem:
    return STORE.problem(goals, samples or SAMPLES)


def moved(facts: frozenset[Fact], sample: str, start: str, end: str) -> frozenset[Fact]:
    """Somebody has carried the sample away."""
    gone = {inside(sample, start), Fact("vacant", (end,))}
    return facts - gone | {inside(sample, end), Fact("vacant", (start,))}


def with_another(problem: PlanningProblem, sample: str, place: str) -> PlanningProblem:
    """Somebody has put one more sample down."""
    return replace(
        problem,
        objects={**problem.objects, sample: "object"},
        facts=problem.facts - {Fact("vacant", (place,))} | {inside(sample, place)},
    )


def outcome(plan_net: PlanNet, facts: frozenset[Fact]) -> frozenset[Fact]:
    """The facts once the plan-net has been carried out as scheduled, from the present ones.

    What is under way has deleted already; each action's conditions hold from its start to its end.
    """
    state = set(facts)
    running = list[PlanNetAction]()
    starts = [(a.earliest_start_s, 1, a) for a in plan_net.actions]
    ends = [(round(a.earliest_end_s, 3), 0, a) for a in plan_net.actions]
    for _, begins, action in sorted([*starts, *ends], key=lambda event: (*event[:2], not event[2].under_way)):
        if begins:
            needs = set(action.preconditions)
            assert state.issuperset(needs - set(action.deletes) if action.under_way else needs), action
            state -= set(action.deletes)
            running.append(action)
        else:
            running.remove(action)
            state |= set(action.effects)
        for other in running:
            assert state.issuperset(set(other.preconditions) - set(other.deletes)), (action, other)
    return frozenset(state)


def check_repair(
    repair: Repair,
    old: Iterable[PlanNetAction],
    present: PlanningProblem,
    knowledge_base: KnowledgeBase,
) -> PlanNet:
    """The repaired plan-net: valid, carried out from the present facts to the goals, as different as it says."""
    plan_net = repair.plan_net
    difference = repair.difference
    assert plan_net is not None, repair.result.reason
    assert difference is not None
    assert faults_of(plan_net, repair.problem.facts, knowledge_base) == []
    assert up_fault(knowledge_base, repair.problem, plan_net) is None
    assert outcome(plan_net, present.facts) >= set(present.goals)
    left = {action.id: action for action in old}
    new = {action.id: action for action in plan_net.actions}
    gone = {*difference.kept, *difference.reassigned, *difference.dropped}
    come = set(left)
    assert gone == come
    assert {*difference.kept.values(), *difference.reassigned.values(), *difference.added} == set(new)
    for one, other in difference.kept.items():
        assert activity(left[one]) == activity(new[other])
        before_s = max(0.0, left[one].earliest_start_s - difference.elapsed_s)
        later_s = new[other].earliest_start_s - before_s
        assert abs(difference.shifted.get(other, 0.0) - later_s) < (
            0.01 if other in difference.shifted else 1.0
        )
    for robot in plan_net.robots:
        places = [
            difference.kept[one.id]
            for one in left.values()
            if robot in one.agents and one.id in difference.kept
        ]
        order = [action.id for action in plan_net.of_robot(robot)]
        assert [name for name in order if name in places] == places
    return plan_net


def activity(action: PlanNetAction) -> tuple[str, tuple[str, ...], Mapping[str, str]]:
    return action.tag, action.agents, action.arguments
