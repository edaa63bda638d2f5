"""Fragments in stores: found alone for each goal, shared by shape (MACTA §5, §6)."""

from dataclasses import replace

import pytest

from planner import Fact, KnowledgeBase
from planner.engines.hierarchical.fragments import fragment as module
from planner.engines.hierarchical.fragments.fragment import Fragments
from planner.engines.hierarchical.fragments.relevance import small_world
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from tests.planner.engines.hierarchical.checks import crew, fragments_of, tags
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside, store_problem

LEG = ["DOCK", "NAVIGATE", "RELEASE2", "TRANSPORT"]


def near(robot: str, place: str) -> Fact:
    return Fact("robot_position", (robot, "near", place))


@pytest.mark.parametrize("bay", ["bay_1", "bay_6", "bay_7", "bay_12"])
def test_a_sample_is_stored_over_the_aisles_interchange(fragments: Fragments, bay: str) -> None:
    problem = store_problem([inside("sample_1", bay)])
    fragment = fragments_of(fragments, problem)[0]
    assert sorted(tags(fragment)) == sorted(LEG * 2)
    store_robot = "store_1" if bay in ("bay_1", "bay_6") else "store_2"
    assert crew(fragment) == {"yard_1", store_robot}  # yard_1 is nearer to door_1 than yard_2


def test_a_sample_passes_three_compartments(fragments: Fragments) -> None:
    problem = Store().problem([inside("s", "bay_1_0")], {"s": "bay_0_0"})
    fragment = fragments_of(fragments, problem)[0]
    assert sorted(tags(fragment)) == sorted(LEG * 3)
    assert {robot.split("_")[0] for robot in crew(fragment)} == {"store", "yard"}


def test_robots_that_stand_in_the_way_are_in_the_smallest_world(fragments: Fragments) -> None:
    standing = {"yard_1": "door_1", "yard_2": "interchange_2", "store_1": "interchange_1", "store_2": "bay_8"}
    samples = {"sample_2": "bay_6"}
    problem = store_problem([inside("sample_2", "bay_10")], samples=samples, robots_at=standing)
    assert fragments.of(problem).alternatives(problem.goals, levels=1)


def test_a_robot_that_holds_something_in_the_open_is_left_alone(
    fragments: Fragments, knowledge_base: KnowledgeBase
) -> None:
    """Only distances tell of where it stands: it is between all places, and in nobody's way."""
    problem = Store(yard_robots=3).problem([inside("s", "bay_1_0")], {"s": "bay_0_0", "t": "door_1"})
    here = {
        ("distance_m", way): 3.0 for place in problem.objects for way in ((place, "open"), ("open", place))
    }
    holding = {
        inside("t", "yard_2"),
        near("yard_2", "open"),
        Fact("robot_attribute", ("yard_2", "gripper", "full")),
    }
    gone = {
        inside("t", "door_1"),
        near("yard_2", "home_yard_2"),
        Fact("robot_attribute", ("yard_2", "gripper", "empty")),
    }
    assert gone <= problem.facts
    problem = replace(
        problem,
        objects={**problem.objects, "open": "location"},
        facts=problem.facts - gone | holding,
        functions={**problem.functions, **here},
    )
    index = WorldIndex(knowledge_base, problem)
    assert {"yard_2", "t"}.isdisjoint(small_world(index, problem.goals, 0))
    first, *_ = fragments.of(problem).alternatives(problem.goals, levels=1)
    assert "t" not in {value for action in first.actions for value in action.arguments.values()}


def test_a_goal_that_holds_needs_no_action(fragments: Fragments) -> None:
    (fragment,) = fragments_of(fragments, store_problem([inside("sample_1", "door_1")]))
    assert fragment.actions == ()


def test_goals_of_one_shape_are_searched_once(fragments: Fragments, monkeypatch: pytest.MonkeyPatch) -> None:
    world = Store(aisles=4, yard_robots=4, doors=4)
    problem = world.problem([], {f"s{n}": f"door_{n}" for n in range(4)})
    assert fragments_of(fragments, problem, [inside("s0", "bay_0_0")])
    monkeypatch.setattr(module, "discover", lambda *_: pytest.fail("searched again"))
    for aisle in range(1, 4):
        (fragment,) = fragments_of(fragments, problem, [inside(f"s{aisle}", f"bay_{aisle}_5")])
        assert f"store_{aisle}_0" in crew(fragment)


def test_what_was_learnt_serves_another_world(fragments: Fragments, monkeypatch: pytest.MonkeyPatch) -> None:
    assert fragments_of(fragments, Store().problem([inside("s", "bay_0_0")], {"s": "door_0"}))
    monkeypatch.setattr(module, "discover", lambda *_: pytest.fail("searched again"))
    other = Store(aisles=5, yard_robots=3, bays=9).problem([inside("t", "bay_4_8")], {"t": "door_1"})
    assert crew(fragments_of(fragments, other)[0]) >= {"store_4_0"}


def test_what_was_learnt_for_longer_ways_does_not_hide_a_shorter_one(fragments: Fragments) -> None:
    world = Store(store_robots=2)
    samples = {"s0": "bay_0_0", "s1": "door_0"}
    assert fragments_of(fragments, world.problem([inside("s1", "bay_0_3")], samples))
    assert fragments_of(fragments, world.problem([inside("s0", "bay_1_3")], samples))
    best = fragments_of(fragments, world.problem([inside("s0", "bay_0_3")], samples))[0]
    assert sorted(tags(best)) == LEG


def test_alternatives_take_other_interchanges(fragments: Fragments) -> None:
    world = Store(interchanges=3)
    found = fragments_of(fragments, world.problem([inside("s", "bay_0_0")], {"s": "door_0"}))
    over = {fragment.actions[-1].arguments["ref1"] for fragment in found}
    assert over == {"interchange_0_0", "interchange_0_1", "interchange_0_2"}


def test_alternatives_take_other_kinds_of_robots(fragments: Fragments) -> None:
    problem = store_problem([inside("sample_1", "door_2")])
    slow = {**problem.functions, ("speed_m_s", ("yard_2",)): 0.1}
    problem = type(problem)(objects=problem.objects, facts=problem.facts, goals=problem.goals, functions=slow)
    found = fragments_of(fragments, problem)
    assert [crew(fragment) for fragment in found] == [{"yard_1"}, {"yard_2"}]


def test_an_occupied_interchange_is_left_aside(fragments: Fragments) -> None:
    world = Store(interchanges=2)
    samples = {"s": "door_0", "t": "interchange_0_0"}
    found = fragments_of(fragments, world.problem([inside("s", "bay_0_0")], samples))
    assert found[0].actions[-1].arguments["ref1"] == "interchange_0_1"


def test_what_occupies_the_target_is_moved_away_first(fragments: Fragments) -> None:
    found = fragments_of(fragments, store_problem([inside("sample_1", "bay_11")]))
    assert "sample_4" in {action.arguments.get("object") for action in found[0].actions}
    places = {
        action.arguments["ref2"]
        for fragment in found
        for action in fragment.actions
        if action.tag == "RELEASE2" and action.arguments["object"] == "sample_4"
    }
    assert 1 <= len(places) <= 4  # a few of the many places to put it


def test_what_occupies_the_only_interchange_is_moved_away_first(fragments: Fragments) -> None:
    samples = {"s": "door_0", "t": "interchange_0_0"}
    found = fragments_of(fragments, Store().problem([inside("s", "bay_0_0")], samples))
    assert "t" in {action.arguments.get("object") for action in found[0].actions}


def test_two_samples_swap_their_bays(fragments: Fragments) -> None:
    problem = store_problem([inside("sample_2", "bay_5"), inside("sample_3", "bay_2")])
    best = fragments_of(fragments, problem)[0]
    assert tags(best).count("RELEASE2") == 3  # one of them is put aside
    assert crew(best) == {"store_1"}


def test_two_samples_swap_across_aisles(fragments: Fragments) -> None:
    goals = [inside("s", "bay_1_0"), inside("t", "bay_0_0")]
    assert fragments_of(fragments, Store().problem(goals, {"s": "bay_0_0", "t": "bay_1_0"}))


def test_a_robot_in_the_way_makes_way(fragments: Fragments) -> None:
    problem = store_problem([near("yard_1", "door_1")], robots_at={"yard_2": "door_1"})
    found = fragments_of(fragments, problem)
    assert found
    assert all(tags(fragment) == ["NAVIGATE", "NAVIGATE"] for fragment in found)


def test_two_robots_change_places(fragments: Fragments) -> None:
    goals = [near("yard_1", "door_1"), near("yard_2", "door_2")]
    problem = store_problem(goals, robots_at={"yard_1": "door_2", "yard_2": "door_1"})
    assert tags(fragments_of(fragments, problem)[0]) == ["NAVIGATE"] * 3


def test_robots_goals_need_the_robot_they_name(fragments: Fragments) -> None:
    (fragment,) = fragments_of(fragments, store_problem([Fact("tracked", ("yard_2", "yard_1"))]))
    assert crew(fragment) == {"yard_2"}


@pytest.mark.parametrize(
    "goal",
    [
        Fact("tracked", ("yard_1", "store_1")),
        inside("sample_1", "home_yard_1"),
        near("yard_1", "bay_1"),
        Fact("clear", ("bay_1", "aisle_1")),
    ],
    ids=str,
)
def test_what_nothing_reaches_is_not_found(fragments: Fragments, goal: Fact) -> None:
    problem = store_problem([goal], robots_at={"store_1": "bay_1"})
    source = fragments.of(problem)
    assert source.alternatives((goal,)) == ()


def test_what_was_given_up_may_be_found_later(fragments: Fragments) -> None:
    goals = (inside("sample_2", "bay_5"), inside("sample_3", "bay_2"))
    source = fragments.of(store_problem(goals))
    assert source.alternatives(goals, is_over=lambda: True) == ()
    assert source.alternatives(goals)


def test_the_nearest_robot_of_a_kind_is_taken(knowledge_base: KnowledgeBase) -> None:
    world = Store(yard_robots=6, doors=6)
    problem = world.problem(
        [inside("s", "door_3")], {"s": "door_4"}, robots_at={f"yard_{n}": f"door_{n}" for n in (0, 5)}
    )
    found = fragments_of(Fragments(knowledge_base), problem)
    assert len(found) == 1
    assert crew(found[0]) == {"yard_5"}


def test_the_same_problem_gives_the_same_fragments(knowledge_base: KnowledgeBase) -> None:
    problem = Store(interchanges=2).problem([inside("s", "bay_0_0")], {"s": "door_0", "t": "bay_0_0"})
    one, other = (fragments_of(Fragments(knowledge_base), problem) for _ in range(2))
    assert one == other
