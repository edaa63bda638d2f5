"""Tasks that stand in each other's way give way: each fragment moves what one task is about."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest

from benchmarks.planner.instances import FAMILIES
from planner import Fact, PlanningProblem, PlanningRequest, faults_of, load_knowledge_base
from planner.engines.hierarchical.blocking import BlockingTasks
from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS
from planner.engines.hierarchical.fragments.fragment import Fragment, Fragments
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.hierarchical.legs.goal_groups import Goals, Group, Groups
from planner.engines.hierarchical.legs.leg import ClassifiedProblem, legs_of
from planner.engines.hierarchical.legs.setups import ReturnHome
from planner.plan_nets.progression import progressed

BASE = load_knowledge_base()


def current(family: str, samples: int, seed: int) -> tuple[PlanningProblem, ClassifiedProblem, Groups]:
    problem = FAMILIES[family](samples, seed).problem(BASE)
    classified = ClassifiedProblem(BASE, problem)
    return problem, classified, Groups(classified)


def ways(
    problem: PlanningProblem, classified: ClassifiedProblem, groups: Groups
) -> Mapping[Group, Sequence[Fragment]]:
    fragments = Fragments(BASE)

    def find(facts: frozenset[Fact], goals: Goals, *, levels: int = ALL_LEVELS) -> Sequence[Fragment]:
        source = fragments.of(replace(problem, facts=facts))
        return source.alternatives(goals, levels=levels)

    found = BlockingTasks(classified, groups, find).ways(groups.wanted)
    assert not isinstance(found, list)
    return found


@pytest.mark.parametrize(("family", "samples"), [("swap", 2), ("relocation", 2), ("blocked", 1)])
@pytest.mark.parametrize("seed", [0, 1])
def test_no_fragment_moves_what_another_task_is_about(family: str, samples: int, seed: int) -> None:
    problem, classified, groups = current(family, samples, seed)
    found = ways(problem, classified, groups)
    assert set(groups.wanted) <= set(found)
    for task, fragments in found.items():
        others = [other for other in found if other != task]
        assert fragments
        assert all(not groups.moved(fragment.actions, others) for fragment in fragments)
        reached = [progressed(problem.facts, fragment.actions) for fragment in fragments]
        assert all(facts.issuperset(task.goals) for facts in reached)


def test_either_of_two_that_change_places_may_be_put_aside() -> None:
    problem, classified, groups = current("swap", 2, 1)
    found = ways(problem, classified, groups)
    for task in groups.wanted:
        places = {groups.put_aside(fragment.actions, task) for fragment in found[task]}
        assert task.goals in places  # straight there
        assert len(places) > 2


def test_what_lies_in_the_way_may_stay_or_go_to_several_places() -> None:
    problem, classified, groups = current("blocked", 1, 0)
    found = ways(problem, classified, groups)
    blocker = next(group for group in found if not group.goals)
    assert any(not fragment.actions for fragment in found[blocker])
    assert len({groups.put_aside(f.actions, blocker) for f in found[blocker] if f.actions}) > 1


def test_a_robot_is_free_between_putting_aside_and_fetching_again() -> None:
    problem, classified, groups = current("swap", 2, 1)
    over = next(
        fragment
        for fragments in ways(problem, classified, groups).values()
        for fragment in fragments
        if len({action.agents for action in fragment.actions}) == 1
        and sum(action.tag == "RELEASE2" for action in fragment.actions) == 2
    )
    legs = legs_of(over.actions, over.goals, classified)
    assert [leg.core[-1].tag for leg in legs] == ["RELEASE2", "RELEASE2"]


def test_agents_that_hold_something_turn_to_other_goals_once_it_is_brought() -> None:
    """A mission under way: both robots of the yard carry a sample, and two more are to be fetched."""
    engine = HierarchicalEngine(BASE)
    problem, _, _ = current("store", 4, 0)
    plan = engine.plan(problem, PlanningRequest(effort_s=0.0)).plan_net
    assert plan is not None
    facts = problem.facts
    for action in plan.actions:
        if "yard" in action.agents[0] and action.tag in ("NAVIGATE", "DOCK", "TRANSPORT"):
            if action.tag == "NAVIGATE" and holds(facts, action.agents[0]):
                continue
            if set(action.preconditions) <= facts:
                facts = facts - set(action.deletes) | set(action.effects)
    assert all(holds(facts, robot) for robot in ("yard_1", "yard_2"))
    under_way = replace(problem, facts=facts)
    found = engine.plan(under_way, PlanningRequest(effort_s=0.0)).plan_net
    assert found is not None
    assert not faults_of(found, facts, BASE)
    released = [action.arguments["object"] for action in found.actions if action.tag == "RELEASE2"]
    assert Counter(released) == dict.fromkeys((f"sample_{n}" for n in range(1, 5)), 2), (
        "something is put down twice"
    )


def holds(facts: frozenset[Fact], robot: str) -> bool:
    return any(fact.predicate == "object_position" and fact.args[2] == robot for fact in facts)


def test_agents_are_back_home_where_later_fragments_begin() -> None:
    problem, classified, groups = current("swap", 2, 1)
    aside = next(f for fragments in ways(problem, classified, groups).values() for f in fragments)
    after = ReturnHome(classified).after(problem.facts, aside.actions)
    assert after != problem.facts
    for agent in classified.agents:
        assert classified.configuration(agent, after) == classified.configuration(agent, problem.facts)


def test_who_says_stop_ends_the_search_for_fragments() -> None:
    problem, _, groups = current("swap", 2, 0)
    together = Group.of(groups.wanted).goals
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked > 2

    index = Fragments(BASE).of(problem)
    assert index.alternatives(together, is_over=stop) == ()
    asked_before = asked
    assert asked_before < 10
    assert index.alternatives(together)
    assert asked == asked_before
