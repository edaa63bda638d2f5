"""PDDL of others as knowledge base and problem."""

import pytest

from planner import KnowledgeBase, PlanningRequest, PlanningStatus, faults_of
from planner.engines.fast_downward import FastDownwardEngine
from planner.errors import Unsupported
from planner.interchange.foreign import import_domain, import_problem
from planner.interchange.pddl import Form, Vocabulary, domain_text, problem_text
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.relaxation import is_relaxed_reachable
from tests.planner.store import inside, small_store, store_problem

DELIVERY = """
(define (domain delivery)
  (:requirements :typing :durative-actions :fluents :negative-preconditions)
  (:types van drone - carrier carrier parcel place - object)
  (:constants depot - place)
  (:predicates (at-place ?x - carrier ?p - place) (waits ?c - parcel ?p - place) (on ?c - parcel ?x - carrier)
               (road ?a ?b - place) (broken ?x - carrier))
  (:functions (road-length ?a ?b - place) (speed ?x - carrier))
  (:durative-action move
    :parameters (?x - carrier ?from ?to - place)
    :duration (= ?duration (/ (road-length ?from ?to) (speed ?x)))
    :condition (and (at start (at-place ?x ?from)) (at start (road ?from ?to)) (over all (not (broken ?x))))
    :effect (and (at start (not (at-place ?x ?from))) (at end (at-place ?x ?to))))
  (:durative-action load
    :parameters (?x - carrier ?c - parcel)
    :duration (= ?duration 3)
    :condition (and (at start (waits ?c depot)) (over all (at-place ?x depot)))
    :effect (and (at start (not (waits ?c depot))) (at end (on ?c ?x))))
  (:durative-action drop
    :parameters (?x - carrier ?c - parcel ?p - place)
    :duration (= ?duration 1/3)
    :condition (and (over all (at-place ?x ?p)) (at start (on ?c ?x)))
    :effect (and (at end (not (on ?c ?x))) (at end (waits ?c ?p)))))
""".replace("1/3", "(/ 1 3)")
TWO_PARCELS = """
(define (problem two) (:domain delivery)
  (:objects v - van d - drone c1 c2 - parcel home - place)
  (:init (at-place v home) (at-place d home) (waits c1 depot) (waits c2 depot) (road home depot) (road depot home)
         (broken d) (= (road-length home depot) 10) (= (road-length depot home) 10) (= (speed v) 2) (= (speed d) 4))
  (:goal (and (waits c1 home) (waits c2 home) (not (on c1 v)))))
"""


def test_a_problem_of_another_domain_is_refused_by_name() -> None:
    other = "; (define (domain logistics)\n" + TWO_PARCELS.replace(
        "(:domain delivery)", "(:domain Logistics)"
    )
    with pytest.raises(Unsupported, match="the problem is one of domain Logistics, not of delivery"):
        import_problem(DELIVERY, other)


def test_a_domain_becomes_a_knowledge_base() -> None:
    file = import_domain(DELIVERY, agents=("carrier",))
    actions = {action.name: action for action in file.actions}
    assert set(actions) == {"MOVE", "LOAD", "DROP"}
    assert actions["MOVE"].duration == "(road_length(from_, to) / speed(x))"
    assert actions["DROP"].duration == "(1.0 / 3.0)"
    assert actions["MOVE"].agents == ("x",)
    assert actions["MOVE"].distinct == ()
    assert set(actions["MOVE"].preconditions) == {"at_place(x, from_)", "road(from_, to)", "not_broken(x)"}
    assert actions["LOAD"].delete == ("waits(c, depot)",)
    assert file.types["place"].values == ("depot",)
    assert file.types["van"].parent == "carrier"


def test_a_problem_is_planned_and_every_check_passes() -> None:
    read = import_problem(DELIVERY, TWO_PARCELS, agents=("carrier",))
    base = read.knowledge_base
    problem = read.problem
    assert not read.is_exact  # durative actions could have been planned inside each other
    assert problem.functions["road_length", ("home", "depot")] == 10.0
    assert str(problem.goals[2]) == "not_on(c1, v)"
    result = FastDownwardEngine(base).plan(problem, PlanningRequest(time_limit_s=100.0))
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert faults_of(result.plan_net, problem.facts, base) == []
    assert result.plan_net.robots == ("v",)  # the drone is broken
    assert result.plan_net.makespan_s == pytest.approx(5 + 3 + 3 + 5 + 1 / 3 + 1 / 3, abs=0.01)


def test_without_stated_agents_the_first_parameter_is_the_agent() -> None:
    assert {action.agents for action in import_domain(DELIVERY).actions} == {("x",)}


def test_unknown_agents_are_refused_with_the_choices() -> None:
    with pytest.raises(Unsupported, match="no type robot; choices: carrier, drone, "):
        import_domain(DELIVERY, agents=("robot",))


CLASSICAL = """
(define (domain d)
  (:requirements :strips :equality :negative-preconditions :action-costs)
  (:predicates (p ?x) (q ?x ?y))
  (:functions (total-cost) (price ?x))
  (:action swap :parameters (?x ?y) :precondition (and (p ?x) (not (p ?y)))
    :effect (and (p ?y) (not (p ?x)) (increase (total-cost) (price ?x))))
  (:action join :parameters (?x ?y) :precondition (and (p ?x) (not (= ?x ?y))) :effect (q ?x ?y))
  (:action rest :parameters () :effect (not (p a)))
  (:action begin :parameters () :effect (p a)))
""".replace("(:predicates", "(:constants a) (:predicates")


def test_inequalities_complements_and_actions_without_parameters_are_kept() -> None:
    actions = {action.name: action for action in import_domain(CLASSICAL).actions}
    assert actions["JOIN"].distinct == (("x", "y"),)
    assert set(actions["SWAP"].delete) == {"p(x)", "not_p(y)"}
    assert set(actions["SWAP"].intended_effects) == {"p(y)", "not_p(x)"}
    assert set(map(frozenset, actions["SWAP"].distinct or ())) == {
        frozenset("xy")
    }  # else it would add and delete the same fact
    assert actions["REST"].intended_effects == ("not_p(a)",)
    assert [parameter.name for parameter in actions["BEGIN"].parameters] == ["performer"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("(over all (not (broken ?x)))", "(over all (or (broken ?x) (road ?from ?to)))", "line 9, action move"),
        ("(over all (not (broken ?x)))", "(at start (exists (?c - parcel) (on ?c ?x)))", "QUANTIFIERS_REMOVING"),
        ("(at end (on ?c ?x))", "(at end (when (broken ?x) (on ?c ?x)))", "CONDITIONAL_EFFECTS_REMOVING"),
        ("(at end (on ?c ?x))", "(at end (increase (speed ?x) 1))", "action load: numeric assignments"),
        ("(at end (on ?c ?x))", "(at end (assign (speed ?x) 1))", "action load: numeric assignments"),
        ("(at end (on ?c ?x))", "(at start (broken ?x)) (at end (not (broken ?x)))", "holds only while it runs"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_its_place_and_the_way_out(old: str, new: str, words: str) -> None:
    assert old in DELIVERY
    with pytest.raises(Unsupported) as refusal:
        import_domain(DELIVERY.replace(old, new, 1))
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    "text", ["", "hello", "(define (domain", "(define (domain d) (:action a))", "(" * 5000]
)
def test_what_is_no_pddl_is_refused(text: str) -> None:
    with pytest.raises(Unsupported, match=r"PDDL|no action"):
        import_domain(text)


@pytest.mark.parametrize("form", [Form.TEMPORAL, Form.CLASSICAL])
def test_what_we_write_comes_back_as_the_same_problem(knowledge_base: KnowledgeBase, form: Form) -> None:
    for place, reachable in (("bay_2", True), ("home_yard_1", False)):
        problem = store_problem(
            [inside("sample_1", place)], samples={"sample_1": "door_1"}, world=small_store()
        )
        words = Vocabulary(knowledge_base, form)
        read = import_problem(domain_text(words), problem_text(words, problem), agents=("robot",))
        assert len(read.knowledge_base.operators) == len(knowledge_base.operators)
        assert is_relaxed_reachable(read.knowledge_base, read.problem) == reachable


def test_reading_leaves_the_lock_free() -> None:
    with pytest.raises(Unsupported):
        import_domain("hello")
    assert UNIFIED_PLANNING_LOCK.acquire(blocking=False)
    UNIFIED_PLANNING_LOCK.release()
