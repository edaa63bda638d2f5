"""The engines by name."""

import pytest

from planner import KnowledgeBase, PlanningRequest, PlanningStatus
from planner.engines.registry import ENGINES, engine_named, is_installed, portfolio
from planner.errors import UnknownEngine
from planner.interchange.foreign import ReadProblem, import_problem

PLACES = """
(define (domain places) (:requirements :strips :typing :negative-preconditions) (:types place)
 (:constants home - place) (:predicates (at ?p - place))
 (:action walk :parameters (?from ?to - place)
  :precondition (and (at ?from) (not (at ?to))) :effect (and (at ?to) (not (at ?from))))
 (:action walk-home :parameters (?from - place)
  :precondition (and (at ?from) (not (at home))) :effect (and (at home) (not (at ?from)))))
"""
"""Its agents are places, for which our own engine finds no way."""
AWAY = """
(define (problem away) (:domain places) (:objects there - place) (:init (at home)) (:goal (at there)))
"""


def only_ours(name: str) -> bool:
    return name == "macta"


@pytest.fixture(scope="module")
def foreign() -> ReadProblem:
    return import_problem(PLACES, AWAY)


def test_every_engine_is_known_by_its_own_name(knowledge_base: KnowledgeBase) -> None:
    assert [engine_named(name, knowledge_base).name for name in ENGINES] == list(ENGINES)


def test_the_portfolio_asks_ours_first(knowledge_base: KnowledgeBase) -> None:
    names = [engine.name for engine in portfolio(knowledge_base).engines]
    assert names == [name for name in ENGINES if is_installed(name)]
    assert names[0] == "macta"
    assert engine_named("portfolio", knowledge_base).name == "portfolio"


def test_engines_that_are_not_installed_are_left_out(knowledge_base: KnowledgeBase) -> None:
    assert [engine.name for engine in portfolio(knowledge_base, only_ours).engines] == ["macta"]


def test_where_a_problem_needs_another_engine_the_answer_names_the_extra(foreign: ReadProblem) -> None:
    alone = portfolio(foreign.knowledge_base, only_ours).plan(foreign.problem, PlanningRequest())
    assert alone.status is PlanningStatus.NOT_FOUND
    assert "not installed: fast-downward, lpg, aries" in alone.reason
    assert "macta[engines]" in alone.reason
    with_it = portfolio(foreign.knowledge_base, lambda name: name in ("macta", "fast-downward"))
    assert with_it.plan(foreign.problem, PlanningRequest()).status is PlanningStatus.SOLVED


def test_an_unknown_name_is_refused_with_the_choices(knowledge_base: KnowledgeBase) -> None:
    with pytest.raises(UnknownEngine, match="choices: portfolio, macta"):
        engine_named("ucpop", knowledge_base)
