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
from dataclasses import replace
from fractions import Fraction
from typing import IO, Any

from unified_planning.engines import Credits, Engine, PlanGenerationResult, PlanGenerationResultStatus
from unified_planning.engines.mixins import AnytimePlannerMixin, OneshotPlannerMixin
from unified_planning.engines.mixins.anytime_planner import AnytimeGuarantee
from unified_planning.engines.mixins.oneshot_planner import OptimalityGuarantee
from unified_planning.engines.results import LogLevel, LogMessage
from unified_planning.model import ProblemKind
from unified_planning.plans import ActionInstance, PartialOrderPlan, TimeTriggeredPlan

from planner.engines.improving_portfolio import ImprovingPortfolio
from planner.engines.plan_net_completion import merit
from planner.engines.registry import improving_portfolio
from planner.errors import Unsupported
from planner.interchange.foreign import ReadProblem, read_up_problem
from planner.interchange.foreign.features import supported_features
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.knowledge import KnowledgeBase
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.plan_nets.validation import sequence_of
from planner.problem.interface import (
    Objective,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    warm_up,
)
from planner.problem.timer import Timer

EPSILON = Fraction(1, 1000)
"""Seconds between the end of an action and the start of one that is ordered after it."""
DEFAULT_TIME_LIMIT_S = 3600.0
"""Time limit if the caller sets none."""
MIN_TIME_LIMIT_S = 0.1
"""Time limit of an attempt that begins when no time is left."""

SHARE_TO_IMPROVE = 0.9
"""Share of the time that is left in which `AnytimePlanner` improves its first plan; the rest is for checks."""

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

    :param agents: the types of agents, each of which does one action at a time. If empty, plans are found as if the
        first parameter of each action were its agent, but may have several actions of one at a time.
    :param make_engine: makes the engine that plans with a knowledge base.
    """

    def __init__(
        self,
        agents: tuple[str, ...] = (),
        make_engine: Callable[[KnowledgeBase], PlanningEngine] = improving_portfolio,
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
        *_, last = self._results(problem, timeout, is_anytime=False)
        return last

    def _get_solutions(
        self, problem: Any, timeout: float | None = None, output_stream: IO[str] | None = None
    ) -> Iterator[PlanGenerationResult]:
        """Yield the first plan found, then the best one that the engines find until the timeout."""
        yield from self._results(problem, timeout, is_anytime=True)

    def _results(
        self, problem: Any, timeout: float | None, *, is_anytime: bool
    ) -> Iterator[PlanGenerationResult]:
        reading = Timer(timeout or DEFAULT_TIME_LIMIT_S)
        objective = _objective(problem)
        try:
            with UNIFIED_PLANNING_LOCK:
                read = read_up_problem(
                    problem, agents=self._agents, costs_as_energy=objective is Objective.ENERGY
                )
        except Unsupported as error:
            yield self._without_plan(PlanGenerationResultStatus.UNSUPPORTED_PROBLEM, str(error))
            return
        engine = self._make_engine(read.knowledge_base)
        limit_s = reading.left_s
        warm_up(engine)  # on a machine's first use it compiles: a problem's time begins only after it
        timer = Timer(limit_s)
        best: PlanNet | None = None
        effort_s = SHARE_TO_IMPROVE * limit_s if is_anytime and timeout is not None else None
        request = PlanningRequest(
            time_limit_s=max(MIN_TIME_LIMIT_S, timer.left_s), effort_s=effort_s, objective=objective
        )
        for result in _answers(engine, read.problem, request):
            if result.plan_net is None and best is None:
                yield self._without_plan(_status(read, result), result.reason)
                return
            found = result.plan_net
            if found is not None and not self._agents:
                found = without_agents(found, read)
            if found is not None and (best is None or merit(found, objective) < merit(best, objective)):
                best = found
                if is_anytime:
                    yield self._solved(PlanGenerationResultStatus.INTERMEDIATE, problem, read, best, result)
        if best is not None:
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


def without_agents(plan_net: PlanNet, read: ReadProblem) -> PlanNet:
    """The plan-net in which agents may do several actions at a time: to the original they are objects like others.

    Only causal links and threats to them order the actions, so that it is no longer, and mostly shorter.
    """
    sequence = [replace(action, agents=()) for action in sequence_of(plan_net)]
    order = extract(sequence, read.problem.facts, plan_net.goals)
    return assemble(order, plan_net.goals, read.knowledge_base, {})


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


def _answers(
    engine: PlanningEngine, problem: PlanningProblem, request: PlanningRequest
) -> Iterator[PlanningResult]:
    """An engine's answers as they come, if it gives several."""
    if isinstance(engine, ImprovingPortfolio):
        yield from engine.answers(problem, request)
    else:
        yield engine.plan(problem, request)


def _objective(problem: Any) -> Objective:
    """The least total cost of actions if a metric asks for that or for the fewest actions, else the makespan."""
    for metric in problem.quality_metrics:
        if metric.is_minimize_action_costs() or metric.is_minimize_sequential_plan_length():
            return Objective.ENERGY
    return Objective.MAKESPAN


def _status(read: ReadProblem, result: PlanningResult) -> PlanGenerationResultStatus:
    """The status for unified-planning: "unsolvable" is proven only if the problem was read exactly."""
    status = _STATUS[result.status]
    if status is PlanGenerationResultStatus.UNSOLVABLE_PROVEN and not read.is_exact:
        return PlanGenerationResultStatus.UNSOLVABLE_INCOMPLETELY
    return status
