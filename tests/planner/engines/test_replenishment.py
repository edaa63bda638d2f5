"""Plans that keep numbers: robots charge on the way, others are recruited, or there is no plan and it is said why."""

import random
from collections.abc import Mapping
from dataclasses import replace

import pytest

from app.cli.trials.offline_mission import goal_problem
from app.cli.trials.random_goals import drawn_goals
from app.domain.world_model import planning_problem
from planner import (
    KnowledgeBase,
    Objective,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    faults_of,
    read_knowledge_base,
)
from planner.engines.registry import engine_named
from planner.interchange.up_validation import up_fault
from planner.problem.number_courses import courses
from planner.repair import NOT_BEGUN, MissionProgress, repair
from robots.world import WorldFile, generate_world, store_shape
from tests.app.sample_store import Store
from tests.planner.knowledge.test_knowledge_base import shipped

STORE = Store()
BASE = STORE.base
GOAL = "in(sample_1, bay_7)"
FULL = dict.fromkeys(("yard_1", "yard_2", "store_1", "store_2"), 0.9)
REQUEST = PlanningRequest(effort_s=0.0)


def stated(levels: Mapping[str, float], *goals: str, world: WorldFile | None = None) -> PlanningProblem:
    """The goals in the sample store with these batteries."""
    facts = [STORE.fact(goal) for goal in goals or (GOAL,)]
    built = planning_problem(world or STORE.world, STORE.facts, facts, knowledge_base=BASE)
    return replace(built, numbers={("battery", (robot,)): level for robot, level in levels.items()})


def asked(problem: PlanningProblem) -> PlanningResult:
    return engine_named("macta", BASE).plan(problem, REQUEST)


def planned(problem: PlanningProblem) -> PlanNet:
    result = asked(problem)
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    check(result.plan_net, problem)
    return result.plan_net


def check(net: PlanNet, problem: PlanningProblem) -> None:
    assert faults_of(net, problem.facts, BASE) == []
    assert up_fault(BASE, problem, net) is None
    for course in courses(net, problem, BASE):
        assert list(course.outside()) == []


def charges(net: PlanNet) -> list[str]:
    return [one.agents[0] for one in net.actions if one.level is not None]


def test_batteries_that_last_change_nothing() -> None:
    assert planned(stated(FULL)) == planned(stated({}))


def test_another_robot_is_recruited_where_that_is_quicker_than_charging() -> None:
    plain = planned(stated({}))
    (first,) = set(plain.robots) & {"yard_1", "yard_2"}
    (other,) = {"yard_1", "yard_2"} - {first}
    net = planned(stated({**FULL, first: 0.2005}))
    assert charges(net) == []
    assert other in net.robots
    assert first not in net.robots


def test_a_robot_is_charged_for_as_long_as_the_rest_of_the_plan_needs() -> None:
    net = planned(stated({**FULL, "store_2": 0.2005}))
    assert charges(net) == ["store_2"]
    (charge,) = [one for one in net.actions if one.tag == "CHARGE"]
    assert charge.level is not None
    (course,) = [
        one for one in courses(net, stated({**FULL, "store_2": 0.2005}), BASE) if "store_2" in one.term[1]
    ]
    assert 0.2 < course.end < 0.23
    assert charge.level == pytest.approx(max(point.value for point in course.points), abs=1e-3)


def test_a_robot_that_is_too_low_from_the_start_is_charged_before_it_does_anything() -> None:
    net = planned(stated({**FULL, "yard_1": 0.12, "yard_2": 0.12}))
    (robot,) = set(charges(net))
    assert net.of_robot(robot)[0].tag == "CHARGE"


def test_without_a_charger_there_is_no_plan_and_it_is_said_why() -> None:
    robots = tuple(robot.model_copy(update={"home": None}) for robot in STORE.world.robots)
    world = STORE.world.model_copy(update={"robots": robots})
    result = asked(stated({**FULL, "store_2": 0.2001}, world=world))
    assert result.status is PlanningStatus.NOT_FOUND
    assert "store_2's battery is at 19.9 % at " in result.reason
    assert "plans keep it at 20 % or more" in result.reason


def test_a_robot_goes_to_its_charger_between_two_goals_and_drives_on_from_there() -> None:
    robots = tuple(
        robot.model_copy(update={"battery_wh": 2.0, "battery": 0.3}) for robot in STORE.world.robots
    )
    world = STORE.world.model_copy(update={"robots": robots})
    goals = ("in(sample_2, bay_1)", "in(sample_3, bay_4)", "in(sample_1, bay_3)")
    problem = stated(dict.fromkeys(FULL, 0.3), *goals, world=world)
    net = planned(problem)
    assert charges(net)
    for robot in charges(net):
        mine = [one.tag for one in net.of_robot(robot)]
        assert "CHARGE" in mine


def drawn(world: WorldFile, seed: int, *, battery_wh: float) -> PlanningProblem:
    """A goal for each sample, with small batteries at random levels."""
    chance = random.Random(seed)
    robots = tuple(
        robot.model_copy(update={"battery": round(chance.uniform(0.2, 0.5), 3), "battery_wh": battery_wh})
        for robot in world.robots
    )
    world = world.model_copy(update={"robots": robots})
    facts = Store(world).facts
    return goal_problem(world, facts, drawn_goals(world, facts, len(world.samples), seed, BASE), BASE)


@pytest.mark.parametrize("seed", range(4))
def test_plans_in_random_stores_keep_all_batteries(seed: int) -> None:
    shape = store_shape(samples=3, aisles=2, store_robots=2, yard_robots=2, doors=2, bays=12)
    problem = drawn(generate_world(shape, seed=seed, in_phases=bool(seed % 2)), seed, battery_wh=1.5)
    net = planned(problem)
    plain = asked(replace(problem, numbers={})).plan_net
    assert plain is not None
    runs_out = any(any(course.outside()) for course in courses(plain, problem, BASE))
    assert runs_out == (net != plain)


def test_a_repair_keeps_the_charge_and_has_it_last_for_the_rest() -> None:
    problem = stated({**FULL, "store_2": 0.2005})
    net = planned(problem)
    again = repair(engine_named("macta", BASE), BASE, net, problem, NOT_BEGUN, REQUEST)
    assert again.result.plan_net is not None
    assert charges(again.result.plan_net) == ["store_2"]
    check(again.result.plan_net, problem)
    (charge,) = [one for one in net.actions if one.tag == "CHARGE"]
    under_way = MissionProgress(under_way={charge.id: 20.0}, elapsed_s=charge.duration_s - 20.0)
    filled = stated({**FULL, "store_2": charge.level - 20.0 * 58 / (120 * 3600)})  # type: ignore[operator]
    rest = repair(engine_named("macta", BASE), BASE, net, filled, under_way, REQUEST).result.plan_net
    assert rest is not None
    (left,) = [one for one in rest.actions if one.tag == "CHARGE"]
    assert left.under_way
    assert left.duration_s == 20.0


def test_a_repair_for_which_batteries_do_not_last_is_planned_anew() -> None:
    net = planned(stated(FULL))
    (robot,) = set(net.robots) & {"yard_1", "yard_2"}
    fallen = stated({**FULL, robot: 0.2005})
    again = repair(engine_named("macta", BASE), BASE, net, fallen, NOT_BEGUN, REQUEST).result.plan_net
    assert again is not None
    check(again, fallen)
    assert robot not in again.robots or robot in charges(again)


def worn_jaws() -> KnowledgeBase:
    """The knowledge base with jaws that wear by gripping and are cleaned at a place, as batteries are charged."""
    text = shipped()
    text = text.replace(
        "quantities:\n",
        "quantities:\n  wear:\n    arguments: {robot: robot}\n    range: [0, null]\n    kept: [null, 1]\n"
        '    phrase: "{robot}\'s jaws are worn by {value}"\n',
        1,
    )
    dock = '    duration: "2.5"\n    energy: 11 * duration() + 5\n'
    assert dock in text
    text = text.replace(dock, f'{dock}    changes: ["wear(robots) += 0.4"]\n', 1)
    clean = (
        "  - identifier: 32\n    name: CLEAN\n    parameters:\n"
        "      - {name: robot, type: robot}\n      - {name: rel, type: relation, values: [near]}\n"
        "      - {name: ref, type: location}\n      - {name: time1, type: time}\n      - {name: time2, type: time}\n"
        "    agents: [robot]\n    preconditions:\n      - robot_position(robot, rel, ref)\n    delete: []\n"
        "    intended_effects:\n      - charged(robot, ref)\n    other_effects: []\n    until: wear(robot) >= 0\n"
        '    changes: ["wear(robot) -= duration() * charger_w(robot, ref) / 580"]\n'
        "    duration: 580 / charger_w(robot, ref)\n"
        '    description: "{robot} clean {rel} {ref}, {time1} to {time2}"\n\n'
    )
    text = text.replace(
        "  - identifier: 30\n    name: MOVE_TO_LEVEL", f"{clean}  - identifier: 30\n    name: MOVE_TO_LEVEL"
    )
    return read_knowledge_base(text, "kb.yaml")


def test_any_number_is_kept_within_limits_by_what_the_knowledge_base_says() -> None:
    base = worn_jaws()
    facts = [STORE.fact(goal) for goal in (GOAL, "in(sample_4, bay_8)")]
    built = planning_problem(STORE.world, STORE.facts, facts, knowledge_base=base)
    numbers = {("wear", (robot,)): 0.5 for robot in FULL} | {("battery", (robot,)): 0.9 for robot in FULL}
    problem = replace(built, numbers=numbers)
    net = engine_named("macta", base).plan(problem, REQUEST).plan_net
    assert net is not None
    assert faults_of(net, problem.facts, base) == []
    (clean,) = [one for one in net.actions if one.tag == "CLEAN"]
    assert clean.agents == ("store_2",)
    assert clean.description.endswith("until store_2's jaws are worn by 0")
    assert all(not list(course.outside()) for course in courses(net, problem, base))


def test_a_goal_to_be_charged_takes_as_long_as_the_battery_needs() -> None:
    goal = "charged(yard_1, home_yard_1)"
    (half,) = planned(stated({**FULL, "yard_1": 0.5}, goal)).actions
    (low,) = planned(stated({**FULL, "yard_1": 0.25}, goal)).actions
    assert (half.tag, half.level, low.level) == ("CHARGE", 0.9, 0.9)
    assert half.duration_s == pytest.approx(0.4 * 120 * 3600 / 58, abs=0.1)
    assert low.duration_s == pytest.approx(0.65 * 120 * 3600 / 58, abs=0.1)
    assert half.description.endswith("until yard_1's battery is at 90 %")


def test_a_robot_whose_battery_is_not_known_is_charged_for_as_long_as_it_may_take() -> None:
    (action,) = planned(stated({}, "charged(yard_1, home_yard_1)")).actions
    assert action.level == 0.9
    assert action.duration_s == pytest.approx((0.9 - 0.2) * 120 * 3600 / 58, abs=0.1)


def small(*goals: str, levels: float | Mapping[str, float]) -> PlanningProblem:
    """With batteries of 2 Wh."""
    robots = tuple(robot.model_copy(update={"battery_wh": 2.0}) for robot in STORE.world.robots)
    known = dict.fromkeys(FULL, levels) if isinstance(levels, float) else levels
    return stated(known, *goals, world=STORE.world.model_copy(update={"robots": robots}))


def test_plans_that_are_most_likely_on_time_keep_their_charges() -> None:
    problem = stated({**FULL, "store_2": 0.2005}, "charged(yard_1, home_yard_1)", GOAL)
    problem = replace(problem, deadlines_s=dict.fromkeys(problem.goals, 3000.0))
    request = replace(REQUEST, objective=Objective.ON_TIME)
    net = engine_named("macta", BASE).plan(problem, request).plan_net
    assert net is not None
    check(net, problem)
    assert {"store_2", "yard_1"} >= set(charges(net)) >= {"yard_1"}


def test_a_robot_that_is_low_does_nothing_before_it_is_charged() -> None:
    """Though it is charged at the end, too, as a goal."""
    goals = (GOAL, "charged(yard_1, home_yard_1)", "charged(yard_2, home_yard_2)")
    net = planned(stated({**FULL, "yard_1": 0.01, "yard_2": 0.01}, *goals))
    for robot in ("yard_1", "yard_2"):
        assert net.of_robot(robot)[0].tag == "CHARGE"


def test_a_repair_of_a_robot_that_has_become_low_charges_it_first() -> None:
    goals = ("in(sample_2, bay_1)", "in(sample_3, bay_4)", "charged(store_1, home_store_1)")
    net = planned(small(*goals, levels=0.9))
    low = small(*goals, levels=0.15)
    again = repair(engine_named("macta", BASE), BASE, net, low, NOT_BEGUN, REQUEST).result.plan_net
    assert again is not None
    check(again, low)


@pytest.mark.parametrize("seed", [8, 10, 14])
def test_robots_take_turns_at_a_charger_that_they_share(seed: int) -> None:
    """In stores where one of them drives to it first, or some are too far from it for what their batteries hold."""
    shape = store_shape(samples=6, aisles=2, store_robots=2, yard_robots=3, doors=2, bays=12)
    net = planned(drawn(generate_world(shape, seed=seed, shared_chargers=True), seed, battery_wh=1.2))
    users = [one.agents[0] for one in net.actions if one.arguments.get("ref") == "charger_yard"]
    assert len(set(users)) > 1


def test_no_charge_lasts_beyond_its_limit() -> None:
    goal = "charged(yard_1, home_yard_1)"
    full = planned(stated({**FULL, "yard_1": 0.999}, goal))
    assert [one.level for one in full.actions] == [0.9]
    net = planned(small("in(sample_2, bay_1)", "in(sample_3, bay_4)", "in(sample_1, bay_3)", levels=0.3))
    assert charges(net)
    fuller = small("in(sample_2, bay_1)", "in(sample_3, bay_4)", "in(sample_1, bay_3)", levels=0.89)
    again = repair(engine_named("macta", BASE), BASE, net, fuller, NOT_BEGUN, REQUEST).result.plan_net
    assert again is not None
    assert all(one.level <= 0.9 for one in again.actions if one.level is not None)
    for course in courses(again, fuller, BASE):
        assert all(point.value <= 0.9 for point in course.points)


def test_a_repair_of_a_goal_to_be_charged_charges_to_its_limit() -> None:
    goal = "charged(yard_1, home_yard_1)"
    net = planned(stated({**FULL, "yard_1": 0.5}, goal))
    less = stated({**FULL, "yard_1": 0.3}, goal)
    again = repair(engine_named("macta", BASE), BASE, net, less, NOT_BEGUN, REQUEST).result.plan_net
    assert again is not None
    (action,) = again.actions
    assert action.level == 0.9
    assert action.duration_s == pytest.approx(0.6 * 120 * 3600 / 58, abs=0.1)


def test_what_a_robot_does_once_its_part_is_done_does_not_count() -> None:
    problem = stated({**FULL, "yard_1": 0.25, "yard_2": 0.25})
    later = replace(problem, not_before_s=dict.fromkeys(problem.goals, 8 * 3600.0))
    assert charges(planned(later)) == []
