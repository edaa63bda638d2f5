"""The hierarchical engine as its users meet it: goals of every kind, each plan-net judged by all who can."""

from collections.abc import Iterable
from dataclasses import replace

import pytest

from planner import (
    Fact,
    KnowledgeBase,
    Objective,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    read_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from tests.planner.engines.hierarchical.judging import planned
from tests.planner.engines.hierarchical.survey import SURVEY, survey
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside, store_problem

REQUEST = PlanningRequest(effort_s=0.0)


def near(robot: str, place: str) -> Fact:
    return Fact("robot_position", (robot, "near", place))


def changed(problem: PlanningProblem, gone: Iterable[Fact], come: Iterable[Fact]) -> PlanningProblem:
    return replace(problem, facts=(problem.facts - set(gone)) | set(come))


def holding(problem: PlanningProblem, robot: str, sample: str, place: str) -> PlanningProblem:
    """The problem with the robot at the place, the sample of the place in its jaws."""
    here = next(f for f in problem.facts if f.predicate == "robot_position" and f.args[0] == robot)
    area = next(f.args[1] for f in problem.facts if f.predicate == "in_area" and f.args[0] == robot)
    return changed(
        problem,
        [
            here,
            inside(sample, place),
            Fact("robot_attribute", (robot, "gripper", "empty")),
            Fact("clear", (place, area)),
        ],
        [
            Fact("robot_position", (robot, "at", place)),
            Fact("clear", (here.args[2], area)),
            inside(sample, robot),
            Fact("robot_attribute", (robot, "gripper", "full")),
            Fact("vacant", (place,)),
        ],
    )


def tags(plan_net: PlanNet) -> list[str]:
    return sorted(action.tag for action in plan_net.actions)


def test_a_robots_goal_beside_a_samples_goal(knowledge_base: KnowledgeBase) -> None:
    planned(knowledge_base, store_problem([near("yard_1", "door_1"), inside("sample_1", "bay_7")]))


def test_robots_goals_alone(knowledge_base: KnowledgeBase) -> None:
    plan_net = planned(knowledge_base, store_problem([near("yard_1", "door_2"), near("yard_2", "door_1")]))
    assert tags(plan_net) == ["NAVIGATE", "NAVIGATE"]


def test_robots_change_places(knowledge_base: KnowledgeBase) -> None:
    goals = [near("yard_1", "door_1"), near("yard_2", "door_2")]
    problem = store_problem(goals, robots_at={"yard_1": "door_2", "yard_2": "door_1"})
    assert tags(planned(knowledge_base, problem)) == ["NAVIGATE"] * 3


def test_a_robot_that_stands_at_its_goal_comes_back_there(knowledge_base: KnowledgeBase) -> None:
    """Only this robot can carry the sample."""
    problem = Store(yard_robots=1).problem(
        [near("yard_0", "home_yard_0"), inside("s", "bay_0_0")], {"s": "door_0"}
    )
    plan_net = planned(knowledge_base, problem)
    assert plan_net.of_robot("yard_0")[-1].tag == "NAVIGATE"


def test_a_robot_that_is_to_stay_stays_where_another_costs_less(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([near("yard_1", "home_yard_1"), inside("sample_1", "bay_7")])
    assert problem.goals[0] in problem.facts
    plan_net = planned(knowledge_base, problem, PlanningRequest(objective=Objective.ENERGY))
    assert "yard_1" not in plan_net.robots


def test_a_robot_comes_to_its_goal_on_purpose(knowledge_base: KnowledgeBase) -> None:
    """To carry the sample there leaves it at its goal only by the way, which does not count."""
    goals = [inside("s", "bay_0_0"), near("yard_0", "interchange_0_0")]
    planned(knowledge_base, Store(aisles=1, yard_robots=1).problem(goals, {"s": "door_0"}))


def test_tracking_beside_a_samples_goal(knowledge_base: KnowledgeBase) -> None:
    goals = [Fact("tracked", ("yard_1", "yard_2")), inside("sample_1", "bay_7")]
    assert "TRACK" in tags(planned(knowledge_base, store_problem(goals)))


def test_goals_that_hold_need_nothing(knowledge_base: KnowledgeBase) -> None:
    goals = [inside("sample_1", "door_1"), near("yard_1", "home_yard_1")]
    assert planned(knowledge_base, store_problem(goals)).actions == ()
    assert planned(knowledge_base, store_problem([])).actions == ()


def test_a_goal_that_holds_and_stands_in_anothers_way_is_reached_again(knowledge_base: KnowledgeBase) -> None:
    """The only interchange is taken by the sample that is to lie there in the end."""
    goals = [inside("t", "interchange_0_0"), inside("s", "bay_0_0")]
    problem = Store(aisles=1).problem(goals, {"s": "door_0", "t": "interchange_0_0"})
    planned(knowledge_base, problem)


def test_a_goal_that_holds_is_left_alone_where_another_way_is_open(knowledge_base: KnowledgeBase) -> None:
    goals = [inside("t", "interchange_0_0"), inside("s", "bay_0_0")]
    problem = Store(aisles=1, interchanges=2).problem(goals, {"s": "door_0", "t": "interchange_0_0"})
    assert len(planned(knowledge_base, problem).actions) == 8


def test_a_taken_target_is_emptied_first(knowledge_base: KnowledgeBase) -> None:
    planned(knowledge_base, store_problem([inside("sample_1", "bay_11")]))


def test_samples_swap_within_an_aisle(knowledge_base: KnowledgeBase) -> None:
    planned(knowledge_base, store_problem([inside("sample_2", "bay_5"), inside("sample_3", "bay_2")]))


def test_samples_swap_across_aisles(knowledge_base: KnowledgeBase) -> None:
    goals = [inside("s", "bay_1_0"), inside("t", "bay_0_0")]
    planned(knowledge_base, Store().problem(goals, {"s": "bay_0_0", "t": "bay_1_0"}))


def test_three_samples_change_places_in_a_circle(knowledge_base: KnowledgeBase) -> None:
    samples = {"r": "bay_0_0", "s": "bay_0_1", "t": "bay_1_0"}
    goals = [inside("r", "bay_0_1"), inside("s", "bay_1_0"), inside("t", "bay_0_0")]
    planned(knowledge_base, Store().problem(goals, samples))


def test_a_sample_passes_three_compartments(knowledge_base: KnowledgeBase) -> None:
    plan_net = planned(knowledge_base, Store().problem([inside("s", "bay_1_0")], {"s": "bay_0_0"}))
    assert len(plan_net.robots) == 3


def test_all_want_the_only_free_bay_to_put_something_aside(knowledge_base: KnowledgeBase) -> None:
    """Both targets are taken and one bay is free; what is freed by the first serves the second."""
    samples = {"a": "bay_0_0", "b": "bay_0_1", "c": "bay_0_2", "d": "bay_0_3"}
    goals = [inside("a", "bay_0_2"), inside("b", "bay_0_3")]
    problem = Store(aisles=1, bays=5).problem(goals, samples)
    planned(knowledge_base, problem)


def test_a_robot_that_holds_the_sample_at_the_start_brings_it(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    held = holding(problem, "yard_2", "sample_1", "door_1")
    plan_net = planned(knowledge_base, held)
    assert "yard_2" in plan_net.robots
    assert "yard_1" not in plan_net.robots


def test_a_robot_that_holds_another_sample_puts_it_down_if_it_is_needed(
    knowledge_base: KnowledgeBase,
) -> None:
    problem = Store(yard_robots=1).problem([inside("s", "bay_0_0")], {"s": "door_0", "t": "door_1"})
    planned(knowledge_base, holding(problem, "yard_0", "t", "door_1"))


def test_robots_stand_where_others_must_work(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem(
        [inside("sample_1", "bay_7")], robots_at={"yard_1": "interchange_2", "yard_2": "door_1"}
    )
    planned(knowledge_base, problem)
    problem = store_problem(
        [inside("sample_1", "bay_7")], robots_at={"yard_1": "interchange_1", "yard_2": "interchange_2"}
    )
    planned(knowledge_base, problem)


def test_a_single_robot_does_all(knowledge_base: KnowledgeBase) -> None:
    problem = Store(aisles=0, yard_robots=1, doors=4).problem(
        [inside("s", "door_2"), inside("t", "door_3"), near("yard_0", "door_0")],
        {"s": "door_0", "t": "door_1"},
    )
    assert planned(knowledge_base, problem).robots == ("yard_0",)


def test_a_single_robot_swaps_two_samples(knowledge_base: KnowledgeBase) -> None:
    problem = Store(aisles=0, yard_robots=1, doors=3).problem(
        [inside("s", "door_1"), inside("t", "door_0")], {"s": "door_0", "t": "door_1"}
    )
    planned(knowledge_base, problem)


@pytest.mark.parametrize("goal", [inside("s", "door_1"), near("yard_0", "door_1")], ids=str)
def test_without_robots_there_is_provably_no_plan(knowledge_base: KnowledgeBase, goal: Fact) -> None:
    problem = Store(aisles=0, yard_robots=0).problem([goal], {"s": "door_0"})
    if goal.predicate == "robot_position":
        problem = replace(problem, objects={**problem.objects, "yard_0": "robot"})
    result = HierarchicalEngine(knowledge_base).plan(problem, REQUEST)
    assert result.status is PlanningStatus.UNSOLVABLE
    assert result.reason


def test_a_skill_that_no_robot_has_is_reported(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    without = [f for f in problem.facts if f.predicate == "can" and f.args[1] == "DOCK"]
    result = HierarchicalEngine(knowledge_base).plan(changed(problem, without, []), REQUEST)
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "DOCK" in result.reason


def test_an_unreachable_goal_beside_a_reachable_one_is_reported(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_7"), near("yard_1", "bay_1")])
    result = HierarchicalEngine(knowledge_base).plan(problem, REQUEST)
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "yard_1" in result.reason


def test_contradictory_goals_have_no_plan(knowledge_base: KnowledgeBase) -> None:
    for goals in (
        [inside("sample_1", "bay_7"), inside("sample_1", "bay_8")],
        [inside("sample_1", "bay_7"), inside("sample_4", "bay_7")],
        [near("yard_1", "door_1"), near("yard_2", "door_1")],
    ):
        result = HierarchicalEngine(knowledge_base).plan(
            store_problem(goals), replace(REQUEST, time_limit_s=4.0)
        )
        assert result.plan_net is None
        assert result.status in (
            PlanningStatus.NOT_FOUND,
            PlanningStatus.TIMED_OUT,
            PlanningStatus.UNSOLVABLE,
        )
        assert result.reason


def test_an_unknown_predicate_or_object_is_reported(knowledge_base: KnowledgeBase) -> None:
    for goal in (Fact("polished", ("sample_1",)), inside("sample_1", "bay_99")):
        result = HierarchicalEngine(knowledge_base).plan(store_problem([goal]), REQUEST)
        assert result.status is PlanningStatus.FAILED
        assert goal.args[-1] in result.reason or goal.predicate in result.reason


def test_a_goal_said_twice_is_reached_once(knowledge_base: KnowledgeBase) -> None:
    assert len(planned(knowledge_base, store_problem([inside("sample_1", "bay_7")] * 2)).actions) == 8


SURVEY_BASE = read_knowledge_base(SURVEY, "survey.yaml")


@pytest.mark.parametrize("rovers", [1, 2, 3])
def test_rovers_photograph_and_come_home(rovers: int) -> None:
    names = ["ann", "bob", "cy"][:rovers]
    goals = [Fact("photographed", ("rock",)), *(Fact("at", (name, "base")) for name in names)]
    planned(SURVEY_BASE, survey(goals, rovers=dict.fromkeys(names, "base")))


def test_two_rovers_carry_a_box_and_one_opens_the_gate() -> None:
    goals = [Fact("stands", ("box", "fork")), Fact("open", ("gate",))]
    problem = survey(goals, rovers={"ann": "base", "bob": "fork", "cy": "base"}, strong=["ann", "bob"])
    plan_net = planned(SURVEY_BASE, problem)
    assert "CARRY" in tags(plan_net)
    assert "OPEN" in tags(plan_net)


def test_a_team_carries_a_box_and_its_members_are_wanted_elsewhere() -> None:
    goals = [Fact("stands", ("box", "fork")), Fact("at", ("ann", "base")), Fact("at", ("bob", "north"))]
    problem = survey(goals, rovers={"ann": "fork", "bob": "fork"}, strong=["ann", "bob"])
    planned(SURVEY_BASE, problem)


def test_a_camera_is_left_on_the_ridge_and_used_before() -> None:
    goals = [Fact("photographed", ("rock",)), Fact("lies", ("camera", "ridge"))]
    planned(SURVEY_BASE, survey(goals, rovers={"ann": "base"}))
