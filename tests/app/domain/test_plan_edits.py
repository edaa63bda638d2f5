"""What operators pin of a plan, by goal."""

import pytest
from pydantic import ValidationError

from app.domain.plan_edits import GoalPin, PlanEdit, applied, together, words_of
from planner import Fact, load_knowledge_base
from robots.wire import SymbolicFact
from tests.planner.store import inside, store_problem

BASE = load_knowledge_base()
STORED = SymbolicFact(predicate="in", args=("sample_1", "bay_7"))
OTHER = SymbolicFact(predicate="in", args=("sample_2", "bay_3"))
GONE = SymbolicFact(predicate="in", args=("sample_99", "bay_7"))


def test_pins_for_one_goal_are_one() -> None:
    first = GoalPin(
        goal=STORED, barred=("yard_2",), not_before_at_s=40.0, after=(OTHER,), words=("without yard_2",)
    )
    second = GoalPin(
        goal=STORED, barred=("yard_1",), avoided=("bay_3",), after=(OTHER,), words=("avoiding bay_3",)
    )
    (pin,) = together([first, second, first])
    assert (pin.barred, pin.avoided, pin.not_before_at_s) == (("yard_1", "yard_2"), ("bay_3",), 40.0)
    assert pin.after == (OTHER,)
    assert words_of((pin,)) == "without yard_2; avoiding bay_3"


def test_pins_make_a_problem_of_the_plans_start() -> None:
    goal: Fact = inside("sample_1", "bay_7")
    pin = GoalPin(goal=STORED, barred=("yard_1",), avoided=("bay_3",), not_before_at_s=40.0)
    problem = applied((pin,), store_problem([goal]), BASE, now_s=15.0)
    assert problem.not_before_s == {goal: 25.0}
    assert problem.avoids == {goal: {"bay_3"}}
    assert problem.recruits == {goal: {"yard_2", "store_1", "store_2"}}


def test_an_order_is_one_of_the_planners_goals() -> None:
    goals = (inside("sample_1", "bay_7"), inside("sample_2", "bay_3"))
    pin = GoalPin(goal=STORED, after=(OTHER, GONE))
    assert applied((pin,), store_problem(goals), BASE, now_s=0.0).after == {goals[0]: {goals[1]}}


def test_a_time_that_is_over_and_what_the_world_no_longer_has_pin_nothing() -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    pins = (GoalPin(goal=STORED, not_before_at_s=10.0), GoalPin(goal=GONE, barred=("yard_1",)))
    assert applied(pins, problem, BASE, now_s=15.0) == problem


def test_an_edit_that_says_nothing_is_refused() -> None:
    with pytest.raises(ValidationError, match="say what is to be otherwise"):
        PlanEdit(action="a1")
