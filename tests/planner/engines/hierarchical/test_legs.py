"""How fragments are cut into legs, and how agents get to where they begin."""

from dataclasses import replace

from planner import Fact, KnowledgeBase
from tests.planner.engines.hierarchical.composing import ProblemSetup, said
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

STORED = inside("sample", "bay_0_3")


def near(robot: str, place: str) -> Fact:
    return Fact("robot_position", (robot, "near", place))


def current(base: KnowledgeBase, *goals: Fact, store: Store | None = None) -> ProblemSetup:
    return ProblemSetup.of(base, (store or Store()).problem(goals or [STORED], {"sample": "door_1"}))


def test_a_fragment_is_cut_where_the_sample_changes_hands(knowledge_base: KnowledgeBase) -> None:
    first, second = current(knowledge_base).legs(STORED)
    assert [action.tag for action in first.core] == ["DOCK", "TRANSPORT", "RELEASE2"]
    assert [action.tag for action in second.core] == ["DOCK", "TRANSPORT", "RELEASE2"]
    assert first.agents[0].startswith("yard")
    assert second.agents == ("store_0_0",)


def test_the_way_to_where_it_begins_is_no_part_of_a_leg_but_a_need(knowledge_base: KnowledgeBase) -> None:
    first, _ = current(knowledge_base).legs(STORED)
    (robot,) = first.agents
    assert near(robot, "door_1") in first.needs[0]
    assert Fact("robot_attribute", (robot, "gripper", "empty")) in first.needs[0]


def test_anybody_of_its_class_may_take_a_leg(knowledge_base: KnowledgeBase) -> None:
    first, second = current(knowledge_base).legs(STORED)
    assert first.bound == second.bound == (False,)
    assert set(first.roles).isdisjoint(second.roles)


def test_a_robot_that_holds_the_sample_already_is_bound_to_its_leg(knowledge_base: KnowledgeBase) -> None:
    """Its like of the same class cannot release what only this one carries."""
    problem = Store().problem([STORED], {"sample": "door_1"}, robots_at={"yard_1": "door_1"})
    empty = Fact("robot_attribute", ("yard_1", "gripper", "empty"))
    full = Fact("robot_attribute", ("yard_1", "gripper", "full"))
    held = problem.facts - {empty, inside("sample", "door_1")} | {full, inside("sample", "yard_1")}
    world = ProblemSetup.of(knowledge_base, replace(problem, facts=held))
    first, second = world.legs(STORED)
    assert (first.agents, first.bound) == (("yard_1",), (True,))
    assert second.bound == (False,)


def test_a_goal_about_where_a_robot_ends_is_a_leg_without_work_of_just_that_robot(
    knowledge_base: KnowledgeBase,
) -> None:
    goal = near("yard_1", "door_0")
    (leg,) = current(knowledge_base, goal).legs(goal)
    assert (leg.agents, leg.core, leg.bound, leg.needs) == (("yard_1",), (), (True,), (frozenset({goal}),))


def test_robots_that_differ_only_in_their_homes_are_alike(knowledge_base: KnowledgeBase) -> None:
    classes = current(knowledge_base).classified.classes
    assert set(classes.members.values()) == {("yard_0", "yard_1"), ("store_0_0",), ("store_1_0",)}


def test_a_way_that_is_met_already_has_no_actions(knowledge_base: KnowledgeBase) -> None:
    world = current(knowledge_base)
    here = world.classified.configuration("yard_0", world.problem.facts)
    way = world.setups("yard_0").way(here, frozenset({near("yard_0", "home_yard_0")}))
    assert way is not None
    assert (way.actions, way.end) == ((), here)


def test_a_way_changes_what_the_agent_must_be_and_nothing_else(knowledge_base: KnowledgeBase) -> None:
    world = current(knowledge_base)
    here = world.classified.configuration("yard_0", world.problem.facts)
    way = world.setups("yard_0").way(here, frozenset({near("yard_0", "door_1")}))
    assert way is not None
    assert said(way.actions) == [("NAVIGATE", "yard_0", "home_yard_0", "door_1")]
    assert way.end == here - {near("yard_0", "home_yard_0")} | {near("yard_0", "door_1")}


def test_there_is_no_way_to_where_the_agent_cannot_go(knowledge_base: KnowledgeBase) -> None:
    world = current(knowledge_base)
    here = world.classified.configuration("yard_0", world.problem.facts)
    assert world.setups("yard_0").way(here, frozenset({near("yard_0", "bay_0_0")})) is None


def test_single_steps_lead_to_every_place_in_reach(knowledge_base: KnowledgeBase) -> None:
    world = current(knowledge_base)
    here = world.classified.configuration("yard_0", world.problem.facts)
    ends = {way.actions[0].arguments["ref2"] for way in world.setups("yard_0").steps(here)}
    assert ends == {"door_0", "door_1", "interchange_0_0", "interchange_1_0"}


def test_there_is_no_way_to_what_no_setup_brings_about(
    knowledge_base: KnowledgeBase,
) -> None:
    """Only docking fills a gripper, and it moves a sample: that is work, no setup."""
    world = current(knowledge_base)
    here = world.classified.configuration("yard_0", world.problem.facts)
    full = Fact("robot_attribute", ("yard_0", "gripper", "full"))
    setups = world.setups("yard_0")
    assert setups.way(here, frozenset({near("yard_0", "door_1"), full})) is None
