"""The best of the schedules that a temporal planner finds."""

from collections.abc import Sequence
from dataclasses import dataclass

from planner.engines.detours import without_detours
from planner.engines.plan_net_completion import complete_plan_net, merit
from planner.errors import InvalidPlan
from planner.interchange.pddl import PddlTask
from planner.knowledge import GroundAction
from planner.plan_nets.extraction import fault_of
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import Observer, PlanningProblem, PlanningRequest, Progress
from planner.problem.static_facts import StaticFacts
from planner.problem.timer import Timer


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A step of a schedule: operator and objects as the PDDL task names them, times in the engine's unit."""

    start: float
    duration: float
    operator: str
    objects: tuple[str, ...]


def sequence_of(task: PddlTask, schedule: Sequence[Step]) -> tuple[GroundAction, ...]:
    """The schedule as a sequence that reaches the goals: by start or, where those overlap too much, by end.

    :raises InvalidPlan: if a step names no operator.
    """
    problem = task.problem
    orders = (
        sorted(schedule, key=lambda step: (step.start, step.start + step.duration)),
        sorted(schedule, key=lambda step: (step.start + step.duration, step.start)),
    )
    sequences = [tuple(task.ground(step.operator, step.objects) for step in order) for order in orders]
    good = (one for one in sequences if fault_of(one, problem.facts, problem.goals) is None)
    return next(good, sequences[0])


MIN_EFFORT_S = 1.0


class BestPlan:
    """Converts schedules to plan-nets, keeps and reports the best, and decides when to stop."""

    def __init__(
        self,
        engine: str,
        problem: PlanningProblem,
        task: PddlTask,
        request: PlanningRequest,
        observer: Observer,
    ) -> None:
        """:param task: what the planner works on, perhaps `problem` without bystanders."""
        self.problem = problem
        self.task = task
        self.plan_net: PlanNet | None = None
        self.rejected = ""
        """Why the last schedule was not acceptable."""
        self._engine = engine
        self._request = request
        self._observer = observer
        self._statics = StaticFacts(task.knowledge_base, problem)
        self._timer = Timer(clock=request.clock)

    def take(self, schedule: Sequence[Step]) -> None:
        """Consider one more schedule; a faulty one is the engine's mistake and ignored."""
        try:
            base = self.task.knowledge_base
            sequence = without_detours(sequence_of(self.task, schedule), self.problem, base)
            plan_net = complete_plan_net(sequence, self.problem, base, self._statics)
        except InvalidPlan as error:
            self.rejected = str(error)
            return
        if isinstance(plan_net, str):
            self.rejected = plan_net
        elif self.plan_net is None or self._merit(plan_net) < self._merit(self.plan_net):
            self._keep(plan_net)

    def is_enough(self) -> bool:
        """True once the effort is spent, or the observer asks to stop."""
        return self._timer.is_over or self._observer.should_stop()

    def _merit(self, plan_net: PlanNet) -> tuple[float, ...]:
        return merit(plan_net, self._request.objective)

    def _keep(self, plan_net: PlanNet) -> None:
        elapsed_s = self._timer.elapsed_s
        if self.plan_net is None:
            effort_s = self._request.effort_s
            # As long again as the first plan took: what comes later seldom is much better (our choice).
            effort_s = max(MIN_EFFORT_S, elapsed_s) if effort_s is None else effort_s
            self._timer.limit_s = elapsed_s + effort_s
        self.plan_net = plan_net
        progress = Progress(engine=self._engine, elapsed_s=elapsed_s, makespan_s=plan_net.makespan_s)
        self._observer.progress(progress)
