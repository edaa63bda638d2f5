"""Repair: what still works of a plan-net is kept as far as that pays, whatever happened to the world."""

from dataclasses import replace

import pytest

from benchmarks.planner.scheduled_progress import as_scheduled
from planner import (
    UNOBSERVED,
    Fact,
    KnowledgeBase,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.errors import UnknownAction
from planner.problem.static_facts import StaticFacts
from planner.repair import NOT_BEGUN, Course, MissionProgress, Repair, repair
from tests.planner.repair.carrying import (
    GOALS,
    check_repair,
    moved,
    outcome,
    problem,
    with_another,
)
from tests.planner.store import inside

REQUEST = PlanningRequest(time_limit_s=30, effort_s=0)
HALFWAY_S = 12.0


class Asked:
    """An engine that counts how often it is asked."""

    name = "asked"

    def __init__(self, engine: HierarchicalEngine) -> None:
        self.engine = engine
        self.times = 0

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        self.times += 1
        return self.engine.plan(problem, request, observer)


@pytest.fixture
def engine(planner: HierarchicalEngine) -> Asked:
    return Asked(planner)


def left_of(plan_net: PlanNet, progress: MissionProgress) -> list[str]:
    return [action.id for action in plan_net.actions if action.id not in progress.done]


def checked(
    engine: Asked,
    knowledge_base: KnowledgeBase,
    plan_net: PlanNet,
    present: PlanningProblem,
    progress: MissionProgress = NOT_BEGUN,
    stability_s: float = 5.0,
) -> Repair:
    """The repair, held to account."""
    made = repair(engine, knowledge_base, plan_net, present, progress, REQUEST, stability_s=stability_s)
    left = [action for action in plan_net.actions if action.id not in progress.done]
    check_repair(made, left, present, knowledge_base)
    return made


def halfway(plan_net: PlanNet) -> tuple[PlanningProblem, MissionProgress]:
    """Both yard robots are on their way with a sample, and one store robot drives."""
    facts, progress = as_scheduled(plan_net, problem().facts, HALFWAY_S)
    assert {plan_net.action(name).tag for name in progress.under_way} == {"TRANSPORT", "NAVIGATE"}
    return replace(problem(), facts=facts), progress


def test_where_nothing_changed_all_is_kept_and_no_engine_is_asked(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    made = checked(engine, knowledge_base, plan_net, problem())
    assert (made.course, engine.times, made.result.engine) == (Course.KEPT, 0, "repair")
    assert made.plan_net is not None
    assert made.plan_net.actions == plan_net.actions
    assert set(made.plan_net.orderings) == set(plan_net.orderings)
    assert made.difference is not None
    assert made.difference.words == ("16 of 16 actions kept, ends when it did",)


def test_what_is_done_is_left_out_and_what_is_under_way_goes_on(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present, progress = halfway(plan_net)
    made = checked(engine, knowledge_base, plan_net, present, progress)
    assert (made.course, engine.times) == (Course.KEPT, 0)
    assert made.plan_net is not None
    assert made.difference is not None
    assert list(made.difference.kept) == left_of(plan_net, progress)
    assert made.difference.shifted == {}
    assert made.plan_net.makespan_s == pytest.approx(plan_net.makespan_s - HALFWAY_S, abs=0.01)
    running = {action.id: action for action in made.plan_net.actions if action.under_way}
    assert {made.difference.kept[name] for name in progress.under_way} == set(running)
    for name, left_s in progress.under_way.items():
        now = running[made.difference.kept[name]]
        assert (now.earliest_start_s, now.duration_s) == (0.0, left_s)
        assert now.distance_m < plan_net.action(name).distance_m


def test_a_robot_that_is_late_shifts_what_waits_for_it(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present, progress = halfway(plan_net)
    late = {
        name: left_s + 20 * ("yard_0" in plan_net.action(name).agents)
        for name, left_s in progress.under_way.items()
    }
    made = checked(engine, knowledge_base, plan_net, present, replace(progress, under_way=late))
    assert made.course is Course.KEPT
    assert made.difference is not None
    assert made.difference.words[1:] == (
        "store_0_0 starts 3 actions 20 s later",
        "yard_0 starts 1 action 20 s later",
    )


def test_a_sample_that_an_operator_moved_is_fetched_from_there_and_the_rest_is_kept(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    facts, progress = as_scheduled(plan_net, problem().facts, 3.0)
    present = replace(problem(), facts=moved(facts, "s1", "door_1", "bay_1_5"))
    made = checked(engine, knowledge_base, plan_net, present, progress, stability_s=50)
    assert made.course is Course.MENDED
    assert made.plan_net is not None
    assert made.difference is not None
    with_s0 = [a.id for a in plan_net.actions if a.arguments.get("object") == "s0"]
    assert set(with_s0) <= set(made.difference.kept)
    with_s1 = [a for a in made.plan_net.actions if a.arguments.get("object") == "s1"]
    assert {robot for action in with_s1 for robot in action.agents} == {"store_1_0"}


def test_another_does_what_a_lost_robot_was_to_do(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    made = checked(engine, knowledge_base, plan_net, problem(), MissionProgress(lost=frozenset({"yard_0"})))
    assert made.plan_net is not None
    assert made.difference is not None
    assert "yard_0" not in made.plan_net.robots
    heirs = {made.plan_net.action(name).agents for name in made.difference.reassigned.values()}
    assert heirs == {("yard_1",)}
    (dock,) = (
        a for a in made.plan_net.of_robot("yard_1") if a.tag == "DOCK" and a.arguments["object"] == "s0"
    )
    assert f"{dock.description}, instead of yard_0" in made.difference.words


def test_a_sample_in_the_way_is_cleared_away_while_the_others_go_on(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present, progress = halfway(plan_net)
    present = with_another(present, "stray", "bay_1_2")
    made = checked(engine, knowledge_base, plan_net, present, progress)
    assert made.course is Course.MENDED
    assert made.difference is not None
    with_s0 = {a.id for a in plan_net.actions if a.arguments.get("object") == "s0"} - progress.done
    assert with_s0 <= set(made.difference.kept)


def test_a_goal_that_is_added_changes_nothing_of_the_others(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present, progress = halfway(plan_net)
    present = with_another(present, "s2", "bay_0_5")
    present = replace(present, goals=(*GOALS, inside("s2", "door_0")))
    made = checked(engine, knowledge_base, plan_net, present, progress)
    assert made.course is Course.MENDED
    assert made.difference is not None
    assert list(made.difference.kept) == left_of(plan_net, progress)
    assert made.difference.shifted == {}


def test_a_goal_that_is_given_up_takes_its_actions_along_but_not_what_is_under_way(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present, progress = halfway(plan_net)
    present = replace(present, goals=GOALS[:1])
    made = checked(engine, knowledge_base, plan_net, present, progress)
    assert made.plan_net is not None
    with_s1 = [a for a in made.plan_net.actions if a.arguments.get("object") == "s1"]
    assert [(a.tag, a.agents, a.under_way) for a in with_s1] == [("TRANSPORT", ("yard_1",), True)]
    assert engine.times == 0


def test_what_is_under_way_takes_its_place_though_nothing_needs_it(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    """A robot on its way holds the place it goes to: another's goal there waits for it to make way."""
    present, progress = halfway(plan_net)
    (name,) = [n for n in progress.under_way if "yard_1" in plan_net.action(n).agents]
    place = plan_net.action(name).arguments["ref2"]
    present = replace(present, goals=(*GOALS[:1], Fact("robot_position", ("yard_0", "near", place))))
    made = checked(engine, knowledge_base, plan_net, present, progress)
    assert made.plan_net is not None
    state = outcome(made.plan_net, present.facts)
    assert Fact("robot_position", ("yard_1", "near", place)) not in state


@pytest.mark.parametrize(("stability_s", "course"), [(0.0, Course.REPLANNED), (50.0, Course.MENDED)])
def test_stability_is_weighed_against_the_makespan(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet, stability_s: float, course: Course
) -> None:
    present = replace(problem(), facts=moved(problem().facts, "s1", "door_1", "bay_0_3"))
    made = checked(engine, knowledge_base, plan_net, present, stability_s=stability_s)
    assert made.course is course
    assert made.plan_net is not None
    again = engine.plan(present, REQUEST).plan_net
    assert again is not None
    if course is Course.REPLANNED:
        assert made.plan_net.makespan_s == again.makespan_s
    else:
        assert made.plan_net.makespan_s > again.makespan_s
        assert made.difference is not None
        assert len(made.difference.kept) >= 12


def test_an_action_under_way_whose_needs_are_gone_is_not_counted_on(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    present, progress = halfway(plan_net)
    (name,) = [n for n in progress.under_way if plan_net.action(n).tag == "NAVIGATE"]
    robot = plan_net.action(name).agents[0]
    home = plan_net.action(name).arguments["ref1"]
    away = frozenset(f for f in present.facts if f != Fact("robot_attribute", (robot, "gripper", "empty")))
    full = {
        Fact("robot_attribute", (robot, "gripper", "full")),
        Fact("robot_position", (robot, "near", home)),
    }
    made = repair(engine, knowledge_base, plan_net, replace(present, facts=away | full), progress, REQUEST)
    assert made.plan_net is None
    assert made.result.status is not PlanningStatus.SOLVED
    assert made.result.reason


def test_without_a_plan_it_says_why(engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet) -> None:
    lost = MissionProgress(lost=frozenset({"yard_0", "yard_1"}))
    made = repair(engine, knowledge_base, plan_net, problem(), lost, REQUEST)
    assert (made.course, made.plan_net, made.difference) == (Course.REPLANNED, None, None)
    assert made.result.status is PlanningStatus.UNSOLVABLE
    assert "no robot reaches door_0" in made.result.reason


def test_all_goals_are_not_planned_again_if_the_caller_does_that(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    lost = MissionProgress(lost=frozenset({"yard_0", "yard_1"}))
    repair(engine, knowledge_base, plan_net, problem(), lost, REQUEST)
    asked, engine.times = engine.times, 0
    made = repair(engine, knowledge_base, plan_net, problem(), lost, REQUEST, replans=False)
    assert made.plan_net is None
    assert engine.times == asked - 1


def test_a_robot_that_has_come_back_is_recruited_only_if_all_is_tried(
    engine: Asked, knowledge_base: KnowledgeBase
) -> None:
    """One robot of the yard was to bring both samples; what is left of that plan can be carried out as it is."""
    without = MissionProgress(lost=frozenset({"yard_1"}))
    alone = problem()
    able = StaticFacts(knowledge_base, alone).without(without.lost)
    plan_net = engine.plan(able, REQUEST).plan_net
    assert plan_net is not None
    engine.times = 0
    kept = repair(engine, knowledge_base, plan_net, alone, NOT_BEGUN, REQUEST)
    assert (kept.course, engine.times) == (Course.KEPT, 0)
    better = repair(engine, knowledge_base, plan_net, alone, NOT_BEGUN, REQUEST, is_thorough=True)
    assert better.plan_net is not None
    assert "yard_1" in better.plan_net.robots
    assert better.plan_net.makespan_s < 0.8 * plan_net.makespan_s


@pytest.mark.parametrize("slot", ["done", "under_way"])
def test_progress_of_actions_there_are_not_is_refused(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet, slot: str
) -> None:
    wrong = (
        MissionProgress(done=frozenset({"a99"}))
        if slot == "done"
        else MissionProgress(under_way={"a99": 1.0})
    )
    with pytest.raises(UnknownAction, match="no action a99; it has a1, a2"):
        repair(engine, knowledge_base, plan_net, problem(), wrong, REQUEST)


def test_a_plan_that_is_done_leaves_nothing_to_do(
    engine: Asked, knowledge_base: KnowledgeBase, plan_net: PlanNet
) -> None:
    facts, progress = as_scheduled(plan_net, problem().facts, 1000.0)
    assert facts >= set(GOALS)
    made = checked(engine, knowledge_base, plan_net, replace(problem(), facts=facts), progress)
    assert made.plan_net is not None
    assert (made.course, made.plan_net.actions, engine.times) == (Course.KEPT, (), 0)
