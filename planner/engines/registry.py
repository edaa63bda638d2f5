"""All engines by name, in the order in which the portfolio asks them: ours, then those of installed packages."""

import logging
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint

from planner.engines.fast_downward import FastDownwardEngine, find_programs
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.engines.improving_portfolio import ImprovingPortfolio
from planner.engines.on_time import OnTimeEngine
from planner.engines.ordered import OrderedEngine
from planner.engines.oversubscription import OversubscriptionEngine
from planner.engines.package_engine import MakeEngine, PackageEngine, package_engines
from planner.engines.peripherals import PeripheralEngine
from planner.engines.portfolio import Portfolio
from planner.engines.preferences import PreferenceEngine
from planner.engines.recruiting import RecruitingEngine
from planner.engines.replenishment import ReplenishingEngine
from planner.engines.staged import StagedEngine
from planner.engines.temporal import Aries, Lpg, TemporalEngine
from planner.errors import UnknownEngine
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningEngine

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
    engines = [_whole(ENGINES[name](knowledge_base), knowledge_base) for name in installed]
    for entry in _of_packages().values():
        try:
            engines.append(_whole(PackageEngine(entry, knowledge_base), knowledge_base))
        except UnknownEngine as error:
            logger.warning("%s", error)
    return Portfolio(engines, missing=missing)


def improving_portfolio(
    knowledge_base: KnowledgeBase, is_installed: Callable[[str], bool] = is_installed
) -> ImprovingPortfolio:
    """The same engines, all of which are asked: for problems of which nobody knows which engine is good at them."""
    usual = portfolio(knowledge_base, is_installed)
    return ImprovingPortfolio(usual.engines, missing=usual.missing)


def engine_named(name: str, knowledge_base: KnowledgeBase) -> PlanningEngine:
    """One engine alone, or the portfolio.

    :raises UnknownEngine: naming the choices, or why a package's engine cannot be made.
    """
    if name == Portfolio.name:
        return portfolio(knowledge_base)
    if name in ENGINES:
        return _whole(ENGINES[name](knowledge_base), knowledge_base)
    if name in (found := _of_packages()):
        return _whole(PackageEngine(found[name], knowledge_base), knowledge_base)
    choices = ", ".join((Portfolio.name, *ENGINES, *found))
    raise UnknownEngine(f"unknown engine {name!r}; choices: {choices}")


def _whole(engine: PlanningEngine, knowledge_base: KnowledgeBase) -> PlanningEngine:
    """The engine with what it need not know of: recruits, goals in an order and in stages, doors and lifts, batteries,
    being in time, preferences, optional goals."""
    if not isinstance(engine, HierarchicalEngine):
        engine = RecruitingEngine(engine, knowledge_base)
    staged = StagedEngine(OrderedEngine(engine, knowledge_base), knowledge_base)
    attending = PeripheralEngine(staged, knowledge_base)
    lasting = ReplenishingEngine(attending, knowledge_base)
    preferring = PreferenceEngine(OnTimeEngine(lasting, knowledge_base), knowledge_base)
    return OversubscriptionEngine(preferring, knowledge_base)


def _of_packages() -> Mapping[str, EntryPoint]:
    """Those of installed packages, by name; a name of ours stays ours."""
    ours = (*ENGINES, Portfolio.name)
    return {name: entry for name, entry in package_engines().items() if name not in ours}
