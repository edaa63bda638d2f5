"""Numbers that plans keep within limits, as PDDL: other validators take our plans and refuse those that run empty."""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from benchmarks.planner.val_validation import is_installed, texts_of, val_fault
from planner import KnowledgeBase, PlanNet, PlanningProblem, PlanningRequest
from planner.engines.registry import engine_named
from planner.errors import Unsupported
from planner.interchange.foreign import import_problem
from planner.interchange.pddl import Form, Vocabulary, pddl_of
from planner.interchange.pddl.levels import level_named
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.problem.number_courses import courses
from robots.world import generate_world, store_shape
from tests.planner.engines.test_replenishment import drawn, worn_jaws
from tests.planner.store import inside, small_store, store_problem

ROBOTS = ("store_1", "yard_1", "yard_2")
FULL = dict.fromkeys(ROBOTS, 0.9)
LOW = {**FULL, "store_1": 0.25}
CAPACITY_J = 5000.0
CHARGER_W = 58.0
needs_val = pytest.mark.skipif(not is_installed(), reason="VAL is not installed: uv sync --extra validation")


def stated(levels: Mapping[str, float], **of_problem: Any) -> PlanningProblem:
    """A sample is to be stored by robots with small batteries at these levels."""
    plain = store_problem([inside("sample_1", "bay_2")], samples={"sample_1": "door_1"}, world=small_store())
    powers = {("capacity_j", (robot,)): CAPACITY_J for robot in ROBOTS}
    powers |= {("charger_w", (robot, f"home_{robot}")): CHARGER_W for robot in ROBOTS}
    numbers = {("battery", (robot,)): level for robot, level in levels.items()}
    return replace(plain, functions={**plain.functions, **powers}, numbers=numbers, **of_problem)


def planned(base: KnowledgeBase, problem: PlanningProblem) -> PlanNet:
    result = engine_named("macta", base).plan(problem, PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None, result.reason
    return result.plan_net


def numeric(base: KnowledgeBase, problem: PlanningProblem) -> tuple[str, str]:
    return pddl_of(base, problem, Form.NUMERIC)


def action_text(domain: str, name: str) -> str:
    start = domain.index(f"(:durative-action {name}\n")
    return domain[start : domain.index("\n  )\n", start)]


def test_an_action_takes_what_it_uses_at_its_start_and_keeps_the_least_battery(
    knowledge_base: KnowledgeBase,
) -> None:
    domain, problem = numeric(knowledge_base, stated(LOW))
    dock = action_text(domain, "dock")
    assert "(at start (decrease (battery ?robots_1) (battery_change_dock ?robots_1)))" in dock
    assert "(at start (>= (battery ?robots_1) 0.2))" in dock
    assert "(over all (>= (battery ?robots_1) 0.2))" in dock
    assert "(battery ?robot - robot)" in domain
    assert "(= (battery store_1) 0.25)" in problem
    assert f"(= (battery_change_dock store_1) {(11 * 2.5 + 5) / CAPACITY_J:g})" in problem


def test_a_team_takes_from_the_battery_of_each_of_its_robots(knowledge_base: KnowledgeBase) -> None:
    text = action_text(numeric(knowledge_base, stated(FULL))[0], "transport_long_object_at")
    for number in (1, 2):
        change = f"battery_change_{number}_transport_long_object_at ?ref1 ?ref2 ?robots_1 ?robots_2"
        assert f"(at start (decrease (battery ?robots_{number}) ({change})))" in text


def test_a_charge_lasts_as_long_as_the_way_to_its_level_takes(knowledge_base: KnowledgeBase) -> None:
    domain, problem = numeric(knowledge_base, stated(LOW))
    charge = action_text(domain, "charge")
    left = "(- (level_battery ?to) (battery ?robot))"
    assert f"(>= ?duration (/ {left} (battery_rate_charge ?robot ?ref)))" in charge
    assert "(at end (assign (battery ?robot) (level_battery ?to)))" in charge
    assert "(at start (<= (level_battery ?to) 0.9))" in charge
    assert f"(= (battery_rate_charge store_1 home_store_1) {CHARGER_W / CAPACITY_J:g})" in problem
    assert "(battery_rate_charge store_1 home_yard_1)" not in problem
    assert "(= (level_battery battery_0_9) 0.9)" in problem
    assert "battery_0_901" not in problem
    assert "battery_0_199" not in problem


def test_a_level_stands_for_no_more_than_is_reached(knowledge_base: KnowledgeBase) -> None:
    words = Vocabulary(knowledge_base, Form.NUMERIC)
    (charge,) = (op for op in words.steps if op.name == "charge")
    found = [level_named(charge, words, value) for value in (0.9, 0.8999, 0.2221, 0.95)]
    assert found == ["battery_0_9", "battery_0_899", "battery_0_222", "battery_0_9"]
    with pytest.raises(ValueError, match="there for no number"):
        level_named(next(op for op in words.steps if op is not charge), words, 0.5)


def test_a_battery_that_is_not_known_is_at_the_least_that_is_kept_and_never_falls(
    knowledge_base: KnowledgeBase,
) -> None:
    _, problem = numeric(knowledge_base, stated({"yard_1": 0.5}))
    assert "(= (battery store_1) 0.2)" in problem
    assert "(= (battery_change_dock store_1) 0)" in problem
    assert "(= (battery_change_dock yard_1) 0)" not in problem


def test_a_robot_that_is_low_from_the_start_may_only_drive_and_charge(knowledge_base: KnowledgeBase) -> None:
    domain, problem = numeric(knowledge_base, stated({**FULL, "store_1": 0.1}))
    assert "(= (least_battery store_1) 0)" in problem
    assert "(= (least_battery yard_1) 0.2)" in problem
    excused = "(at start (>= (battery ?robots_1) (least_battery ?robots_1)))"
    assert excused in action_text(domain, "navigate_phase_3")
    assert excused not in action_text(domain, "dock")
    assert "(at end (assign (least_battery ?robot) 0.2))" in action_text(domain, "charge")


def test_other_forms_have_no_numbers(knowledge_base: KnowledgeBase) -> None:
    known, unknown = stated(LOW), stated({})
    for form in (Form.TEMPORAL, Form.CLASSICAL):
        assert pddl_of(knowledge_base, known, form) == pddl_of(knowledge_base, unknown, form)
        assert "battery" not in pddl_of(knowledge_base, known, form)[0]


def test_our_own_reader_refuses_numbers_rather_than_ignore_them(knowledge_base: KnowledgeBase) -> None:
    with pytest.raises(Unsupported, match="numeric conditions cannot be planned with"):
        import_problem(*numeric(knowledge_base, stated(FULL)), agents=["robot"])


def test_what_raises_a_number_does_so_at_its_end_and_keeps_the_most() -> None:
    base = worn_jaws()
    dock = action_text(numeric(base, stated(FULL))[0], "dock")
    assert "(at end (increase (wear ?robots_1) (wear_change_dock ?robots_1)))" in dock
    assert "(at start (<= (wear ?robots_1) 1))" in dock
    assert "(at end (<= (+ (wear ?robots_1) (wear_change_dock ?robots_1)) 1))" in dock


def worn(by: float) -> PlanningProblem:
    """Batteries are full, and the jaws of all robots are worn."""
    problem = stated(FULL)
    return replace(problem, numbers={**problem.numbers, **{("wear", (robot,)): by for robot in ROBOTS}})


def test_a_number_that_is_lowered_has_levels_down_to_its_limit() -> None:
    base = worn_jaws()
    words = Vocabulary(base, Form.NUMERIC)
    (clean,) = (op for op in words.steps if op.name == "clean")
    assert [level_named(clean, words, value) for value in (0.0, 0.2221)] == ["wear_0", "wear_0_223"]
    domain, problem = numeric(base, worn(1.5))
    assert "(= (most_wear store_1) 1000000)" in problem
    assert "(= (wear_rate_clean store_1 home_store_1) -0.1)" in problem
    assert "(at end (assign (wear ?robot) (level_wear ?to)))" in action_text(domain, "clean")


@needs_val
def test_val_refuses_a_plan_that_wears_more_than_is_kept() -> None:
    base = worn_jaws()
    plain = planned(base, worn(0.5))
    cleaning = planned(base, worn(0.7))
    assert [action.tag for action in cleaning.actions if action.level is not None] == ["CLEAN", "CLEAN"]
    assert val_fault(base, worn(0.5), plain) is None
    assert val_fault(base, worn(0.7), plain) is not None
    assert val_fault(base, worn(0.7), cleaning) is None


@needs_val
@pytest.mark.parametrize("level", [0.9, 0.25, 0.15])
def test_val_takes_our_plan_and_refuses_one_that_leaves_the_battery_out(
    knowledge_base: KnowledgeBase, level: float
) -> None:
    problem = stated({**FULL, "store_1": level})
    plan_net = planned(knowledge_base, problem)
    assert val_fault(knowledge_base, problem, plan_net) is None
    careless = planned(knowledge_base, stated({}))
    fault = val_fault(knowledge_base, problem, careless)
    assert (fault is None) == (level == 0.9)
    assert fault is None or "battery store_1" in fault or "Invariant" in fault


@needs_val
def test_val_refuses_a_plan_that_charges_too_little(knowledge_base: KnowledgeBase) -> None:
    problem = stated(LOW)
    plan_net = planned(knowledge_base, problem)
    (charge,) = (action for action in plan_net.actions if action.tag == "CHARGE")
    hurried = replace(charge, duration_s=0.1)
    actions = tuple(hurried if action is charge else action for action in plan_net.actions)
    fault = val_fault(knowledge_base, problem, replace(plan_net, actions=actions))
    assert fault is not None
    assert "Invariant" in fault


@needs_val
@pytest.mark.parametrize("seed", range(2))
def test_val_judges_batteries_in_random_stores_as_we_do(knowledge_base: KnowledgeBase, seed: int) -> None:
    """With phases, too."""
    shape = store_shape(samples=3, aisles=2, store_robots=2, yard_robots=2, doors=2, bays=12)
    problem = drawn(generate_world(shape, seed=seed, in_phases=bool(seed % 2)), seed, battery_wh=1.5)
    plan_net = planned(knowledge_base, problem)
    careless = planned(knowledge_base, replace(problem, numbers={}))
    assert any(any(course.outside()) for course in courses(careless, problem, knowledge_base))
    assert val_fault(knowledge_base, problem, plan_net) is None
    assert val_fault(knowledge_base, problem, careless) is not None


def test_unified_planning_takes_our_plan_and_refuses_one_that_leaves_the_battery_out(
    knowledge_base: KnowledgeBase,
) -> None:
    plain = planned(knowledge_base, stated({}))
    charging = planned(knowledge_base, stated(LOW))
    assert [action.agents for action in charging.actions if action.tag == "CHARGE"] == [("store_1",)]
    with UNIFIED_PLANNING_LOCK:
        read = _Read(knowledge_base, stated(LOW))
        assert read.takes(charging)
        assert not read.takes(plain)
        read.set_battery("store_1", Fraction(9, 10))
        assert read.takes(plain)
        read.set_battery("store_1", Fraction(22, 100))
        assert not read.takes(charging), "the charge is too short now"


class _Read:
    """A numeric problem as unified-planning reads it, which takes seconds."""

    def __init__(self, base: KnowledgeBase, problem: PlanningProblem) -> None:
        from unified_planning.io import PDDLReader

        self._base = base
        self._stated = problem
        self._reader = PDDLReader()
        self._problem = self._reader.parse_problem_string(*numeric(base, problem))

    def set_battery(self, robot: str, level: Fraction) -> None:
        battery = self._problem.fluent("battery")
        self._problem.set_initial_value(battery(self._problem.object(robot)), level)

    def takes(self, plan_net: PlanNet) -> bool:
        """What unified-planning's validator says of the plan."""
        from unified_planning.engines.plan_validator import TimeTriggeredPlanValidator
        from unified_planning.engines.results import ValidationResultStatus
        from unified_planning.plans import TimeTriggeredPlan

        text = texts_of(self._base, self._stated, plan_net)["plan"]
        timed = self._reader.parse_plan_string(self._problem, text).timed_actions
        exact = [(start, one, self._exact(one) or duration) for start, one, duration in timed]
        validator = TimeTriggeredPlanValidator()
        validator.skip_checks = True  # it does not expect functions without values, which no step here reads
        answer = validator.validate(self._problem, TimeTriggeredPlan(exact, self._problem.environment))
        return answer.status is ValidationResultStatus.VALID

    def _exact(self, instance: Any) -> Fraction | None:
        """The duration if it is fixed: plans have it rounded, and the validator compares exactly."""
        from unified_planning.model import UPState
        from unified_planning.model.walkers.state_evaluator import StateEvaluator

        span = instance.action.duration
        if span.lower != span.upper:
            return None
        bound = dict(zip(instance.action.parameters, instance.actual_parameters, strict=True))
        state = UPState(self._problem.explicit_initial_values, self._problem)
        value = StateEvaluator(self._problem).evaluate(span.lower.substitute(bound), state=state)
        return Fraction(value.constant_value())
