"""The engines by name."""

import pytest

from planner import KnowledgeBase
from planner.engines.registry import ENGINES, engine_named, portfolio
from planner.errors import UnknownEngine


def test_every_engine_is_known_by_its_own_name(knowledge_base: KnowledgeBase) -> None:
    assert [engine_named(name, knowledge_base).name for name in ENGINES] == list(ENGINES)


def test_the_portfolio_asks_ours_first(knowledge_base: KnowledgeBase) -> None:
    names = [engine.name for engine in portfolio(knowledge_base).engines]
    assert names[0] == "macta"
    assert "fast-downward" in names
    assert engine_named("portfolio", knowledge_base).name == "portfolio"


def test_an_unknown_name_is_refused_with_the_choices(knowledge_base: KnowledgeBase) -> None:
    with pytest.raises(UnknownEngine, match="choices: portfolio, macta"):
        engine_named("ucpop", knowledge_base)
