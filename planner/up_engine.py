"""Macta's planner as an engine of unified-planning: `OneshotPlanner(name="macta")` and `AnytimePlanner`.

unified-planning finds engines in its configuration file or by its factory. Either
`planner.register_with_unified_planning()`, or in `up.ini`:

    [engine macta]
    module_name: planner.up_engine
    class_name: MactaEngine

Classical problems get partial-order plans, durative ones time-triggered plans, in which an action
starts `EPSILON` after the last one that it is ordered after.
"""

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import IO, Any

from unified_planning.engines import Credits, Engine, PlanGenerationResult, PlanGenerationResultStatus
from unified_planning.engines.mixins import AnytimePlannerMixin, OneshotPlannerMixin
from unified_planning.engines.mixins.anytime_planner import AnytimeGuarantee
from unified_planning.engines.mixins.oneshot_planner import OptimalityGuarantee
from unified_planning.engines.results import LogLevel, LogMessage
from unified_planning.model import ProblemKind
from unified_planning.plans import ActionInstance, PartialOrderPlan, TimeTriggeredPlan

from planner.engines.registry import portfolio
from planner.errors import Unsupported
from planner.interchange.foreign import ReadProblem, read_up_problem
from planner.interchange.foreign.features import supported_features
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.problem.interface import PlanningEngine, PlanningRequest, PlanningResult, PlanningStatus
from planner.problem.timer import Timer

EPSILON = Fraction(1, 1000)
"""Seconds between the end of an action and the start of one that is ordered after it."""
DEFAULT_TIME_LIMIT_S = 3600.0
"""Time limit if the caller sets none."""
MIN_TIME_LIMIT_S = 0.1
"""Time limit of an attempt that begins when no time is left."""
NO_EFFORT_S = 0.0
"""`PlanningRequest.effort_s` of an attempt that does not improve the first plan it finds."""

_STATUS = {
    PlanningStatus.SOLVED: PlanGenerationResultStatus.SOLVED_SATISFICING,
    PlanningStatus.UNSOLVABLE: PlanGenerationResultStatus.UNSOLVABLE_PROVEN,
    PlanningStatus.NOT_FOUND: PlanGenerationResultStatus.UNSOLVABLE_INCOMPLETELY,
    PlanningStatus.TIMED_OUT: PlanGenerationResultStatus.TIMEOUT,
    PlanningStatus.OUT_OF_MEMORY: PlanGenerationResultStatus.MEMOUT,
    PlanningStatus.FAILED: PlanGenerationResultStatus.INTERNAL_ERROR,
}


class MactaEngine(Engine, OneshotPlannerMixin, AnytimePlannerMixin):  # type: ignore[misc]
    """Reads a unified-planning problem, plans it, and returns the plan in unified-planning's form.

    :param agents: the types of agents, each of which does one action at a time; if empty, the first parameter of
        each action is its agent.
    :param make_engine: makes the engine that plans with a knowledge base.
    """

    def __init__(
        self,
        agents: tuple[str, ...] = (),
        make_engine: Callable[[KnowledgeBase], PlanningEngine] = portfolio,
        **_: Any,
    ) -> None:
        Engine.__init__(self)
        OneshotPlannerMixin.__init__(self)
        AnytimePlannerMixin.__init__(self)
        self._agents = agents
        self._make_engine = make_engine

    @property
    def name(self) -> str:
        return "macta"

    @staticmethod
    def supported_kind() -> ProblemKind:
        return ProblemKind(supported_features(), version=2)

    @staticmethod
    def supports(problem_kind: ProblemKind) -> bool:
        return bool(problem_kind <= MactaEngine.supported_kind())

    @staticmethod
    def satisfies(optimality_guarantee: OptimalityGuarantee) -> bool:
        return optimality_guarantee is OptimalityGuarantee.SATISFICING

    @staticmethod
    def ensures(anytime_guarantee: AnytimeGuarantee) -> bool:
        return anytime_guarantee is AnytimeGuarantee.INCREASING_QUALITY

    @staticmethod
    def get_credits(**_: Any) -> Credits:
        description = "Hierarchical planning and scheduling for teams of robots, plan-nets with causal links"
        return Credits("Macta", "The Macta authors", "", "", "", description, description)

    def _solve(
        self,
        problem: Any,
        heuristic: Callable[[Any], float | None] | None = None,
        timeout: float | None = None,
        output_stream: IO[str] | None = None,
    ) -> PlanGenerationResult:
        *_, last = self._results(problem, timeout, efforts=(None,))
        return last

    def _get_solutions(
        self, problem: Any, timeout: float | None = None, output_stream: IO[str] | None = None
    ) -> Iterator[PlanGenerationResult]:
        """Yield the first plan found, then the best one."""
        yield from self._results(problem, timeout, efforts=(NO_EFFORT_S, None))

    def _results(
        self, problem: Any, timeout: float | None, efforts: tuple[float | None, ...]
    ) -> Iterator[PlanGenerationResult]:
        timer = Timer(timeout or DEFAULT_TIME_LIMIT_S)
        try:
            with UNIFIED_PLANNING_LOCK:
                read = read_up_problem(problem, agents=self._agents)
        except Unsupported as error:
            yield self._without_plan(PlanGenerationResultStatus.UNSUPPORTED_PROBLEM, str(error))
            return
        engine = self._make_engine(read.knowledge_base)
        best: PlanNet | None = None
        for effort_s in efforts:
            limit_s = max(MIN_TIME_LIMIT_S, timer.left_s)
            result = engine.plan(read.problem, PlanningRequest(time_limit_s=limit_s, effort_s=effort_s))
            if result.plan_net is None and best is None:
                yield self._without_plan(_status(read, result), result.reason)
                return
            if result.plan_net is not None and (best is None or result.plan_net.makespan_s < best.makespan_s):
                best = result.plan_net
            if effort_s is not None and best is not None:
                yield self._solved(PlanGenerationResultStatus.INTERMEDIATE, problem, read, best, result)
            elif best is not None:
                yield self._solved(PlanGenerationResultStatus.SOLVED_SATISFICING, problem, read, best, result)

    def _without_plan(self, status: PlanGenerationResultStatus, reason: str) -> PlanGenerationResult:
        return PlanGenerationResult(status, None, self.name, log_messages=[LogMessage(LogLevel.INFO, reason)])

    def _solved(
        self,
        status: PlanGenerationResultStatus,
        problem: Any,
        read: ReadProblem,
        plan_net: PlanNet,
        result: PlanningResult,
    ) -> PlanGenerationResult:
        metrics = {"engine": result.engine, "makespan_s": f"{plan_net.makespan_s:g}"}
        return PlanGenerationResult(status, up_plan(problem, read, plan_net), self.name, metrics)


def up_plan(problem: Any, read: ReadProblem, plan_net: PlanNet) -> Any:
    """The plan-net as a plan of the unified-planning problem that was read."""
    instances = {action.id: _instance(problem, read, action) for action in plan_net.actions}
    if not problem.kind.has_continuous_time() and not problem.kind.has_discrete_time():
        order: dict[ActionInstance, list[ActionInstance]] = {instance: [] for instance in instances.values()}
        for ordering in plan_net.orderings:
            order[instances[ordering.before]].append(instances[ordering.after])
        return PartialOrderPlan(order, problem.environment)
    starts: dict[str, Fraction] = {}
    timed = []
    spans = {name: _span(problem, read, instances[name]) for name in instances}
    for action in sorted(plan_net.actions, key=lambda action: (action.earliest_start_s, int(action.id[1:]))):
        before = [o.before for o in plan_net.orderings if o.after == action.id]
        ends = [starts[name] + (spans[name] or 0) + EPSILON for name in before]
        starts[action.id] = max(ends, default=Fraction(0))
        timed.append((starts[action.id], instances[action.id], spans[action.id]))
    return TimeTriggeredPlan(timed, problem.environment)


def _instance(problem: Any, read: ReadProblem, action: PlanNetAction) -> ActionInstance:
    origin = read.actions[action.tag]
    expression = problem.environment.expression_manager.ObjectExp
    objects = [read.objects[action.arguments[name]] for name in origin.up_parameters]
    return ActionInstance(origin.up_action, tuple(map(expression, objects)))


def _span(problem: Any, read: ReadProblem, instance: ActionInstance) -> Fraction | None:
    """The exact duration, None for an instantaneous action."""
    duration = getattr(instance.action, "duration", None)
    if duration is None:
        return None
    manager = problem.environment.expression_manager
    parameters = map(manager.ParameterExp, instance.action.parameters)
    substitution = dict(zip(parameters, instance.actual_parameters, strict=True))
    return _value(problem, duration.lower.substitute(substitution))


def _value(problem: Any, expression: Any) -> Fraction:
    """Evaluate a ground expression over static functions."""
    if expression.is_fluent_exp():
        return _value(problem, problem.initial_value(expression))
    parts = [_value(problem, part) for part in expression.args]
    if expression.is_plus():
        return sum(parts, Fraction(0))
    if expression.is_minus():
        return parts[0] - parts[1]
    if expression.is_times():
        product = Fraction(1)
        for part in parts:
            product *= part
        return product
    return parts[0] / parts[1] if expression.is_div() else Fraction(expression.constant_value())


def _status(read: ReadProblem, result: PlanningResult) -> PlanGenerationResultStatus:
    """The status for unified-planning: "unsolvable" is proven only if the problem was read exactly."""
    status = _STATUS[result.status]
    if status is PlanGenerationResultStatus.UNSOLVABLE_PROVEN and not read.is_exact:
        return PlanGenerationResultStatus.UNSOLVABLE_INCOMPLETELY
    return status
