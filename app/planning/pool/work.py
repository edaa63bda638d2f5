"""The work of planning processes: the engine that each makes, the kinds of work, and the type of their results.

Everything here is picklable, as it passes between the service and a planning process.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Generic, TypeAlias, TypeVar

from app.domain.blockers import Blockers
from app.domain.goal_language.conflict_set import ConstraintConflict
from planner import (
    KEPT_S,
    Fact,
    Forecast,
    KnowledgeBase,
    Observer,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Preference,
    load_knowledge_base,
    merge_knowledge_bases,
    shipped_knowledge_base,
)
from planner.alternatives import alternatives, with_choices_of
from planner.explanation import Explanation, explain
from planner.plan_nets.completion import forecast
from planner.repair import NOT_BEGUN, MissionProgress, Repair, edit, repair, without_hopeless_pins
from robots.compilation import Group, compile_once

Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkResult(Generic[Answer]):
    """The result of work; a missing answer is a result, not an exception.

    :param answer: set exactly when solved.
    :param reason: why there is no answer, for operators; may be empty.
    :param waits_for: the missions and robots that may prevent an answer.
    :param is_refused: nothing was planned, as the goal is impossible in the present world; the reason says so.
    :param conflict: the constraints that stand in the way, if they are known.
    """

    status: PlanningStatus
    answer: Answer | None = None
    reason: str = ""
    waits_for: Blockers = field(default_factory=Blockers)
    is_refused: bool = False
    conflict: ConstraintConflict | None = None

    @classmethod
    def solved(cls, answer: Answer) -> "WorkResult[Answer]":
        return cls(status=PlanningStatus.SOLVED, answer=answer)

    @property
    def why(self) -> str:
        """The reason, or the status if the reason is empty."""
        return self.reason or self.status.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """A plan that was found.

    :param repair: how it was made from another plan; None if it was not.
    :param label: what it is best at among the alternatives.
    :param comparison: what it costs and saves against the shortest alternative, in words.
    :param forecast: when its goals are likely achieved.
    """

    result: PlanningResult
    forecast: Forecast | None = None
    repair: Repair | None = None
    label: str = ""
    comparison: str = ""


Solutions: TypeAlias = tuple[Solution, ...]
Work: TypeAlias = Callable[[PlanningEngine, Observer], WorkResult[Answer]]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanWork:
    """Plan a problem."""

    problem: PlanningProblem
    request: PlanningRequest

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Solutions]:
        return _of_result(engine.plan(self.problem, self.request, observer), self.problem)


@dataclass(frozen=True, slots=True, kw_only=True)
class RepairWork:
    """Repair a plan, parts of which may be done.

    If there is no plan with all that is awarded or pinned, it no longer counts for the goals that it leaves no way to;
    if there is no plan with the rest either, none of it does, orders included.

    :param is_thorough: see `planner.repair.repair`; likewise `stability_s`.
    """

    knowledge_base: KnowledgeBase
    plan_net: PlanNet
    problem: PlanningProblem
    request: PlanningRequest
    progress: MissionProgress = field(default=NOT_BEGUN)
    is_thorough: bool = False
    stability_s: float = KEPT_S

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Solutions]:
        problem = self.problem
        repaired = self._repaired(engine, observer, problem)
        if repaired.plan_net is not None or not (problem.recruits or problem.avoids or problem.after):
            return _of_result(repaired.result, problem, repaired)
        wanted = without_hopeless_pins(problem, self.knowledge_base)
        if wanted != problem:
            repaired = self._repaired(engine, observer, wanted)
        if repaired.plan_net is None:
            free = replace(problem, recruits={}, avoids={}, after={})
            repaired = self._repaired(engine, observer, free)
        return _of_result(repaired.result, self.problem, repaired)

    def _repaired(self, engine: PlanningEngine, observer: Observer, problem: PlanningProblem) -> Repair:
        return repair(
            engine,
            self.knowledge_base,
            self.plan_net,
            problem,
            self.progress,
            self.request,
            observer,
            stability_s=self.stability_s,
            is_thorough=self.is_thorough,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class EditWork:
    """Plan a problem that something is pinned of, with as few changes of a plan as pays."""

    knowledge_base: KnowledgeBase
    plan_net: PlanNet
    problem: PlanningProblem
    request: PlanningRequest

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Solutions]:
        edited = edit(engine, self.knowledge_base, self.plan_net, self.problem, self.request, observer)
        return _of_result(edited.result, self.problem, edited)


@dataclass(frozen=True, slots=True, kw_only=True)
class AlternativesWork:
    """Find alternatives to a proposed plan, itself included.

    :param preferences: of the goal; those that the proposed plan keeps are constraints of the problem.
    """

    knowledge_base: KnowledgeBase
    problem: PlanningProblem
    request: PlanningRequest
    count: int
    proposed: PlanningResult
    preferences: tuple[Preference, ...] = ()

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Solutions]:
        found = alternatives(
            engine,
            self.knowledge_base,
            self.problem,
            self.request,
            observer,
            k=self.count,
            proposed=self.proposed,
        )
        if not found:
            return WorkResult(
                status=PlanningStatus.NOT_FOUND, reason="no plan was found for the present world"
            )
        return WorkResult.solved(
            tuple(
                Solution(
                    result=with_choices_of(self.proposed, one.result, self.preferences),
                    label=one.label,
                    comparison=one.words,
                    forecast=one.forecast,
                )
                for one in found
            )
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplainWork:
    """Explain a plan, with the cost of its constraints and of omitting each of its robots.

    :param withheld: facts that the problem leaves out though they hold, each with why, in words.
    :param without: by constraint, in words, the problem without that one.
    """

    knowledge_base: KnowledgeBase
    plan_net: PlanNet
    problem: PlanningProblem
    request: PlanningRequest
    withheld: Mapping[Fact, str] = field(default_factory=dict)
    without: Mapping[str, PlanningProblem] = field(default_factory=dict)

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Explanation]:
        return WorkResult.solved(self._explained(engine, observer))

    def without_costs(self) -> Explanation:
        """The explanation without what needs planning."""
        return self._explained(None, Observer())

    def _explained(self, engine: PlanningEngine | None, observer: Observer) -> Explanation:
        return explain(
            self.plan_net,
            self.problem,
            self.knowledge_base,
            engine,
            self.request,
            observer,
            withheld=self.withheld,
            without=self.without,
        )


def _of_result(
    result: PlanningResult, problem: PlanningProblem, repaired: Repair | None = None
) -> WorkResult[Solutions]:
    if result.plan_net is None:
        return WorkResult(status=result.status, reason=result.reason)
    likely = forecast(result.plan_net, problem.deadlines_s, problem.spreads)
    return WorkResult.solved((Solution(result=result, repair=repaired, forecast=likely),))


def compile_planner() -> None:
    """Call the planner's compiled functions."""
    from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine

    HierarchicalEngine(load_knowledge_base()).warm_up()


PLANNER = Group(name="planner", compile=compile_planner)


def make_engine(tell: Callable[[str], None], knowledge_bases: tuple[Path, ...] = ()) -> PlanningEngine:
    """The planning engine, warm. Called inside the planning process.

    :param knowledge_bases: the files it plans with; none: the one that ships.
    :param tell: called with messages about what takes time.
    """
    compile_once(PLANNER, tell)
    # NOTE: imported here: only the planning process needs the engines, whose import takes seconds.
    from planner.engines.registry import portfolio

    engine = portfolio(merge_knowledge_bases(knowledge_bases or [shipped_knowledge_base()]))
    engine.warm_up()
    return engine
