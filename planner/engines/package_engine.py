"""Engines of installed packages, whose plan-nets are checked before they are passed on."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points

from planner.errors import UnknownEngine
from planner.knowledge import KnowledgeBase
from planner.plan_nets.validation import faults_of
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    warm_up,
)

MakeEngine = Callable[[KnowledgeBase], PlanningEngine]

GROUP = "macta.engines"
"""The entry points by which packages add engines: each a `MakeEngine` (docs/packs.md)."""


def package_engines() -> Mapping[str, EntryPoint]:
    """The entry points of installed packages' engines, by name."""
    found = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
    return {entry.name: entry for entry in found}


class PackageEngine:
    """A package's engine. A faulty plan-net of it is a `FAILED` result that says what is wrong with it."""

    def __init__(self, entry: EntryPoint, knowledge_base: KnowledgeBase) -> None:
        """:raises UnknownEngine: if the engine cannot be made."""
        self.name = entry.name
        self._knowledge_base = knowledge_base
        try:
            self._engine: PlanningEngine = entry.load()(knowledge_base)
            if self._engine.name != self.name:
                raise ValueError(f"its name is {self._engine.name!r}")
        except Exception as error:
            source = entry.value if entry.dist is None else f"{entry.value} of {entry.dist.name}"
            raise UnknownEngine(f"engine {self.name} cannot be made by {source}: {error}") from error

    def warm_up(self) -> None:
        warm_up(self._engine)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        result = self._engine.plan(problem, request, observer)
        if result.plan_net is None:
            return result
        faults = faults_of(result.plan_net, problem.facts, self._knowledge_base)
        if set(result.plan_net.goals) != set(problem.goals):
            faults.append("its goals are not those of the problem")
        if not faults:
            return result
        reason = f"its plan-net is faulty: {'; '.join(faults)}"
        return replace(result, status=PlanningStatus.FAILED, plan_net=None, reason=reason)
