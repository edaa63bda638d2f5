"""Engines of installed packages."""

import logging
from pathlib import Path

import pytest

from planner import KnowledgeBase
from planner.engines.registry import engine_named, package_engines, portfolio
from planner.errors import UnknownEngine
from tests.packages import installed, write_package

PYTHON = """\
from planner import PlanningResult, PlanningStatus


class Oracle:
    name = "oracle"

    def __init__(self, knowledge_base):
        self.knowledge_base = knowledge_base

    def plan(self, problem, request, observer):
        return PlanningResult(status=PlanningStatus.NOT_FOUND, engine=self.name, planning_s=0.0)


def broken(knowledge_base):
    raise RuntimeError("out of tea leaves")
"""
ENTRY_POINTS = """\
[macta.engines]
broken = planning_oracle:broken
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
    assert asked[-1] == "oracle"
    assert asked.count("oracle") == 1
    assert (
        "broken cannot be made by planning_oracle:broken of planning_oracle: out of tea leaves" in caplog.text
    )


def test_a_name_of_ours_stays_ours(site: Path, knowledge_base: KnowledgeBase) -> None:
    with installed(site):
        assert "macta" not in package_engines()
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
