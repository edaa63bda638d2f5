"""What operators pin of a plan, by goal."""

import pytest
from pydantic import ValidationError

from app.domain.errors import Invalid
from app.domain.plan_edits import GoalPin, PlanEdit, applied, pins_of, together, words_of
from app.domain.world_model import initial_facts, planning_problem
from planner import Fact, PlanNet, PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.repair import edit
from robots.wire import SymbolicFact
from robots.world import WorldFile
from robots.world.generate import generate_world, store_shape
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


def one_aisle_with_two_interchanges() -> WorldFile:
    world = generate_world(store_shape(samples=1, aisles=1, interchanges=2, bays=4)).model_dump()
    (sample,) = world["samples"]
    return WorldFile.model_validate(world | {"samples": [sample | {"at": "door_1"}]})


def ways(plan_net: PlanNet | None) -> set[str]:
    assert plan_net is not None
    used = {name for action in plan_net.actions for name in action.arguments.values()}
    return {name for name in used if name.startswith("interchange")}


@pytest.mark.parametrize("index", [0, 4, -1])
def test_samples_go_by_the_interchange_that_is_pinned_to_any_action(index: int) -> None:
    world, engine = one_aisle_with_two_interchanges(), HierarchicalEngine(BASE)
    problem = planning_problem(world, initial_facts(world, BASE), [inside("sample_1", "bay_3")])
    plan = engine.plan(problem, PlanningRequest()).plan_net
    assert plan is not None
    (way,) = ways(plan)
    (other,) = {"interchange_1", "interchange_2"} - {way}
    asked = PlanEdit(action=plan.actions[index].id, via=other)
    pins = pins_of([asked], plan, problem, BASE, world=world, now_s=0.0)
    assert pins == (
        GoalPin(
            goal=SymbolicFact(predicate="in", args=("sample_1", "bay_3")),
            avoided=(way,),
            words=(f"via {other} for in(sample_1, bay_3)",),
        ),
    )
    edited = edit(engine, BASE, plan, applied(pins, problem, BASE, now_s=0.0), PlanningRequest())
    assert ways(edited.plan_net) == {other}


def test_what_the_goal_is_about_is_no_way_that_is_avoided() -> None:
    world, engine = one_aisle_with_two_interchanges(), HierarchicalEngine(BASE)
    problem = planning_problem(world, initial_facts(world, BASE), [inside("sample_1", "interchange_1")])
    plan = engine.plan(problem, PlanningRequest()).plan_net
    assert plan is not None
    via = PlanEdit(action=plan.actions[-1].id, via="interchange_2")
    assert pins_of([via], plan, problem, BASE, world=world, now_s=0.0)[0].avoided == ()
    wrong = PlanEdit(action=plan.actions[-1].id, via="bay_1")
    with pytest.raises(Invalid, match="samples go through interchange_1 and interchange_2"):
        pins_of([wrong], plan, problem, BASE, world=world, now_s=0.0)
