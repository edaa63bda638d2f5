"""All engines by name, in the order in which the portfolio asks them."""

from collections.abc import Callable, Mapping

from planner.engines.fast_downward import FastDownwardEngine, find_programs
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.portfolio import Portfolio
from planner.engines.staged import StagedEngine
from planner.engines.temporal import Aries, Lpg, TemporalEngine
from planner.errors import UnknownEngine
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningEngine

ENGINES: Mapping[str, Callable[[KnowledgeBase], PlanningEngine]] = {
    HierarchicalEngine.name: HierarchicalEngine,
    # Before LPG, which solves larger problems but proves nothing: most goals that get this far have no plan, and a
    # proof saves the operator's time.
    FastDownwardEngine.name: FastDownwardEngine,
    Lpg.name: lambda knowledge_base: TemporalEngine(knowledge_base, Lpg()),
    Aries.name: lambda knowledge_base: TemporalEngine(knowledge_base, Aries()),
}
"""All engines; an optional one that is not installed answers `FAILED`."""

_OPTIONAL: Mapping[str, Callable[[], bool]] = {
    FastDownwardEngine.name: lambda: find_programs() is not None,
    Lpg.name: lambda: Lpg().is_installed,
    Aries.name: lambda: Aries().is_installed,
}


def is_installed(name: str) -> bool:
    """Whether an engine can be run here."""
    return name not in _OPTIONAL or _OPTIONAL[name]()


def portfolio(knowledge_base: KnowledgeBase, is_installed: Callable[[str], bool] = is_installed) -> Portfolio:
    """All engines that are installed: ours first, then those that need no composition."""
    installed = [name for name in ENGINES if is_installed(name)]
    missing = [name for name in ENGINES if name not in installed]
    engines = [StagedEngine(ENGINES[name](knowledge_base), knowledge_base) for name in installed]
    return Portfolio(engines, missing=missing)


def engine_named(name: str, knowledge_base: KnowledgeBase) -> PlanningEngine:
    """One engine alone, or the portfolio.

    :raises UnknownEngine: naming the choices.
    """
    if name == Portfolio.name:
        return portfolio(knowledge_base)
    if name not in ENGINES:
        raise UnknownEngine(f"unknown engine {name!r}; choices: {', '.join((Portfolio.name, *ENGINES))}")
    return StagedEngine(ENGINES[name](knowledge_base), knowledge_base)
