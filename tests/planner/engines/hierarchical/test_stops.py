"""Stops: variants of fragments in which a loaded robot clears a place early."""

from collections import Counter

import pytest

from planner import KnowledgeBase
from planner.engines.hierarchical.legs.stops import NEAR_STOPS, with_near_stops, with_stops
from planner.plan_nets.extraction import fault_of
from tests.planner.engines.hierarchical.composing import ProblemSetup, Sequenced, said
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

FETCHED = inside("sample", "door_9")


@pytest.fixture
def world(knowledge_base: KnowledgeBase) -> ProblemSetup:
    """A sample comes out of an aisle to a door far away."""
    problem = Store(aisles=1, doors=10).problem(
        [FETCHED, inside("other", "door_8")], {"sample": "bay_0_0", "other": "bay_0_1"}
    )
    return ProblemSetup.of(knowledge_base, problem)


def carried(actions: Sequenced) -> list[tuple[str, ...]]:
    return [one[2:] for one in said(actions) if one[0] == "TRANSPORT" and one[1].startswith("yard")]


def test_a_robot_may_stop_at_its_own_home(world: ProblemSetup) -> None:
    fragment = world.quickest(FETCHED)
    fragments = with_stops([fragment], world.stops())
    assert fragments[0] == fragment
    assert {tuple(carried(varied)) for varied in fragments[1:]} == {
        (("interchange_0_0", home), (home, "door_9")) for home in ("home_yard_0", "home_yard_1")
    }


def test_what_a_robot_does_after_a_stop_speaks_of_the_stop(world: ProblemSetup) -> None:
    _, *varied = with_stops([world.quickest(FETCHED)], world.stops())
    for fragment in varied:
        release = fragment[-1]
        assert (release.tag, release.arguments["rel1"]) == ("RELEASE2", "near")
        assert release.arguments["ref1"] == f"home_{release.agents[0]}"


def test_nobody_stops_on_a_short_way(knowledge_base: KnowledgeBase) -> None:
    goal = inside("sample", "door_0")
    world = ProblemSetup.of(knowledge_base, Store(aisles=1).problem([goal], {"sample": "bay_0_0"}))
    assert with_stops([world.quickest(goal)], world.stops()) == (world.quickest(goal),)


def test_places_that_several_tasks_leave_are_left_for_near_ones(world: ProblemSetup) -> None:
    tasks = [(world.quickest(goal),) for goal in world.problem.goals]
    varied = with_near_stops(tasks, world.stops())
    stops = Counter(carried(fragment)[0][1] for some in varied for fragment in some[1:])
    assert set(stops) == {"door_0", "door_1", "door_2"}
    assert len(stops) == NEAR_STOPS
    for goal, some in zip(world.problem.goals, varied, strict=True):
        for fragment in some:
            assert fault_of(fragment, world.problem.facts, [goal]) is None


def test_places_that_one_task_leaves_are_not_cleared_early(world: ProblemSetup) -> None:
    tasks = [(world.quickest(FETCHED),)]
    assert with_near_stops(tasks, world.stops()) == tasks
