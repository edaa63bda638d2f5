"""Why each robot was chosen."""

from dataclasses import replace

from planner import Fact, KnowledgeBase
from planner.explanation.recruiting import recruitment_of
from planner.interchange.foreign import import_problem
from planner.problem.static_facts import StaticFacts
from tests.planner.large_store import LargeStore


def test_a_robot_that_could_do_all_of_anothers_work_would_qualify(knowledge_base: KnowledgeBase) -> None:
    store = LargeStore(aisles=3, samples=3)
    problem = store.problem()
    lame = Fact("can", ("yard_2", "DOCK"))
    problem = replace(problem, facts=problem.facts - {lame})
    work = [action for action in store.sequence(problem, knowledge_base) if "yard_0" in action.agents]
    why = recruitment_of(work, StaticFacts(knowledge_base, problem))
    assert list(why) == ["yard_0"]
    assert "yard_1 would qualify too" in why["yard_0"]
    assert "yard_2" not in why["yard_0"]
    assert why["yard_0"].startswith("can NAVIGATE, DOCK, TRANSPORT and RELEASE2 and serves ")


def test_rivals_are_distinguished_by_whether_they_have_work(knowledge_base: KnowledgeBase) -> None:
    store = LargeStore(aisles=3, samples=2)
    problem = store.problem()
    why = recruitment_of(store.sequence(problem, knowledge_base), StaticFacts(knowledge_base, problem))
    assert "yard_2 would qualify too, the plan found has no need of it" in why["yard_0"]
    assert why["yard_0"].endswith("; yard_1 would qualify too but has other work")
    assert why["yard_1"].endswith("; yard_0 would qualify too but has other work")
    assert why["store_0"].endswith("no other robot qualifies")


def test_what_a_robot_serves_are_objects_and_not_what_it_must_know(knowledge_base: KnowledgeBase) -> None:
    """Phases need that their robots know the packets for them: `can(yard_0, NAVIGATE_OFF)`."""
    store = LargeStore(aisles=1, samples=1)
    knows = Fact("can", ("yard_0", "NAVIGATE_OFF"))
    problem = store.problem()
    problem = replace(problem, facts=problem.facts | {knows})
    work = [
        replace(action, preconditions=(*action.preconditions, knows))
        for action in store.sequence(problem, knowledge_base)
        if "yard_0" in action.agents
    ]
    why = recruitment_of(work, StaticFacts(knowledge_base, problem))
    can, *_ = why["yard_0"].partition(";")
    assert "NAVIGATE_OFF" not in can.partition(" and serves ")[2]


def test_a_robot_kept_from_every_action_is_no_rival(knowledge_base: KnowledgeBase) -> None:
    store = LargeStore(aisles=3, samples=1)
    problem = store.problem()
    without = StaticFacts(knowledge_base, problem).without({"yard_1", "yard_2"})
    why = recruitment_of(store.sequence(problem, knowledge_base), StaticFacts(knowledge_base, without))
    assert why["yard_0"].endswith("no other robot qualifies")


def test_whatever_acts_is_a_robot_though_its_type_has_another_name() -> None:
    domain = """(define (domain d) (:requirements :typing) (:types truck place) (:predicates (at ?t - truck ?p - place))
      (:action drive :parameters (?t - truck ?a ?b - place) :precondition (at ?t ?a)
       :effect (and (not (at ?t ?a)) (at ?t ?b))))"""
    problem = """(define (problem p) (:domain d) (:objects t1 t2 - truck x y - place)
      (:init (at t1 x) (at t2 x)) (:goal (at t1 y)))"""
    read = import_problem(domain, problem, agents=["truck"])
    arguments = {"t": "t1", "a": "x", "b": "y"}
    drive = read.knowledge_base.ground("DRIVE", arguments, {}, objects=read.problem.objects)
    why = recruitment_of([drive], StaticFacts(read.knowledge_base, read.problem))
    assert why == {"t1": "can DRIVE; t2 would qualify too, the plan found has no need of it"}
