"""All engines by name, in the order in which the portfolio asks them: ours, then those of installed packages."""

import logging
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint, entry_points

from planner.engines.fast_downward import FastDownwardEngine, find_programs
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.portfolio import Portfolio
from planner.engines.staged import StagedEngine
from planner.engines.temporal import Aries, Lpg, TemporalEngine
from planner.errors import UnknownEngine
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningEngine

MakeEngine = Callable[[KnowledgeBase], PlanningEngine]

GROUP = "macta.engines"
"""The entry points by which installed packages add engines: each a `MakeEngine` (docs/packs.md)."""

logger = logging.getLogger(__name__)

ENGINES: Mapping[str, MakeEngine] = {
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
    """All engines that are installed: ours first, then those that need no composition, then those of packages."""
    installed = [name for name in ENGINES if is_installed(name)]
    missing = [name for name in ENGINES if name not in installed]
    engines = [StagedEngine(ENGINES[name](knowledge_base), knowledge_base) for name in installed]
    for name in package_engines():
        try:
            engines.append(StagedEngine(_of_package(name, knowledge_base), knowledge_base))
        except UnknownEngine as error:
            logger.warning("%s", error)
    return Portfolio(engines, missing=missing)


def engine_named(name: str, knowledge_base: KnowledgeBase) -> PlanningEngine:
    """One engine alone, or the portfolio.

    :raises UnknownEngine: naming the choices, or why a package's engine cannot be made.
    """
    if name == Portfolio.name:
        return portfolio(knowledge_base)
    if name in ENGINES:
        return StagedEngine(ENGINES[name](knowledge_base), knowledge_base)
    if name in (found := package_engines()):
        return StagedEngine(_of_package(name, knowledge_base), knowledge_base)
    choices = ", ".join((Portfolio.name, *ENGINES, *found))
    raise UnknownEngine(f"unknown engine {name!r}; choices: {choices}")


def package_engines() -> Mapping[str, EntryPoint]:
    """The entry points of installed packages' engines, by name; a name of ours stays ours."""
    found = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
    return {entry.name: entry for entry in found if entry.name not in (*ENGINES, Portfolio.name)}


def _of_package(name: str, knowledge_base: KnowledgeBase) -> PlanningEngine:
    """:raises UnknownEngine: if it cannot be made."""
    entry = package_engines()[name]
    try:
        engine: PlanningEngine = entry.load()(knowledge_base)
        if engine.name != name:
            raise ValueError(f"its name is {engine.name!r}")
    except Exception as error:
        source = entry.value if entry.dist is None else f"{entry.value} of {entry.dist.name}"
        raise UnknownEngine(f"engine {name} cannot be made by {source}: {error}") from error
    return engine
