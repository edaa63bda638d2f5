"""Engines of installed packages."""

import logging
from pathlib import Path

import pytest

from planner import KnowledgeBase, PlanningRequest, PlanningStatus
from planner.engines.registry import engine_named, portfolio
from planner.errors import UnknownEngine
from tests.packages import installed, write_package
from tests.planner.store import inside, store_problem

REQUEST = PlanningRequest(time_limit_s=20, effort_s=0)
PYTHON = """\
from dataclasses import replace

from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine


class Oracle:
    name = "oracle"

    def __init__(self, knowledge_base):
        self.knowledge_base = knowledge_base

    def plan(self, problem, request, observer):
        found = HierarchicalEngine(self.knowledge_base).plan(problem, request, observer)
        return replace(found, engine=self.name)


class Liar(Oracle):
    name = "liar"

    def plan(self, problem, request, observer):
        found = super().plan(problem, request, observer)
        return replace(found, plan_net=replace(found.plan_net, causal_links=()))


def broken(knowledge_base):
    raise RuntimeError("out of tea leaves")
"""
ENTRY_POINTS = """\
[macta.engines]
broken = planning_oracle:broken
liar = planning_oracle:Liar
lost = planning_oracle:Nothing
macta = planning_oracle:Oracle
misnamed = planning_oracle:Oracle
oracle = planning_oracle:Oracle
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    return write_package(tmp_path, "planning_oracle", ENTRY_POINTS, {"planning_oracle.py": PYTHON})


def test_an_installed_engine_can_be_named_and_is_the_portfolios_last(
    site: Path, knowledge_base: KnowledgeBase, caplog: pytest.LogCaptureFixture
) -> None:
    with installed(site), caplog.at_level(logging.WARNING):
        assert engine_named("oracle", knowledge_base).name == "oracle"
        asked = [engine.name for engine in portfolio(knowledge_base).engines]
    assert asked[0] == "macta"
    assert asked[-2:] == ["liar", "oracle"]
    assert asked.count("oracle") == 1
    assert (
        "broken cannot be made by planning_oracle:broken of planning_oracle: out of tea leaves" in caplog.text
    )


def test_a_name_of_ours_stays_ours(site: Path, knowledge_base: KnowledgeBase) -> None:
    with installed(site):
        assert "oracle" not in [engine.name for engine in portfolio(knowledge_base).engines[:1]]
        assert type(engine_named("macta", knowledge_base)).__module__.startswith("planner.")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("broken", "out of tea leaves"),
        ("lost", "Nothing"),
        ("misnamed", "its name is 'oracle'"),
        ("seer", "unknown engine 'seer'; choices: portfolio, macta"),
    ],
)
def test_an_engine_that_cannot_be_made_is_named_with_its_package(
    site: Path, knowledge_base: KnowledgeBase, name: str, words: str
) -> None:
    with installed(site), pytest.raises(UnknownEngine) as refused:
        engine_named(name, knowledge_base)
    assert words in str(refused.value)
    assert ("planning_oracle" in str(refused.value)) or name == "seer"


def test_the_choices_name_the_packages_engines(site: Path, knowledge_base: KnowledgeBase) -> None:
    with installed(site), pytest.raises(UnknownEngine, match="oracle"):
        engine_named("seer", knowledge_base)


def test_a_packages_plan_is_passed_on_if_it_is_valid(site: Path, knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    with installed(site):
        found = engine_named("oracle", knowledge_base).plan(problem, REQUEST)
    assert (found.status, found.engine) == (PlanningStatus.SOLVED, "oracle")


def test_a_packages_faulty_plan_is_a_failure_that_says_what_is_wrong(
    site: Path, knowledge_base: KnowledgeBase
) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    with installed(site):
        failed = engine_named("liar", knowledge_base).plan(problem, REQUEST)
    assert failed.status is PlanningStatus.FAILED
    assert failed.plan_net is None
    assert failed.reason.startswith("its plan-net is faulty: ")
