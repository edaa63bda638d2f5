"""The hierarchical engine behind the `PlanningEngine` seam (MACTA §6 asks for one; §4: planning and scheduling
intertwined)."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from planner.bounds import lower_bound_s
from planner.bounds import warm_up as warm_up_bounds
from planner.engines.detours import without_detours
from planner.engines.garbage_collection import garbage_collection_paused
from planner.engines.hierarchical.composition import Composition, effort
from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS
from planner.engines.hierarchical.fragments.fragment import Fragment, Fragments, ProblemFragments
from planner.engines.hierarchical.legs.goal_groups import Goals, Groups
from planner.engines.hierarchical.legs.leg import FactClassifier
from planner.engines.hierarchical.legs.setups import ReturnHome
from planner.engines.hierarchical.legs.stops import (
    MAX_NEAR_STOPPING,
    SHARE,
    Stops,
    with_near_stops,
    with_stops,
)
from planner.engines.hierarchical.scheduling.model import Floats
from planner.engines.hierarchical.scheduling_problem import Task
from planner.engines.hierarchical.tasks import TaskFinder, Unmet
from planner.engines.plan_net_completion import complete_plan_net, confirm, timed_result, to_result
from planner.explanation.diagnosis import why_unsolvable
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract, fault_of
from planner.plan_nets.validation import unjustified_actions
from planner.problem.contradiction import contradicting_goals
from planner.problem.interface import (
    UNOBSERVED,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)
from planner.problem.robot_classes import AgentClasses
from planner.problem.static_facts import StaticFacts
from planner.relaxation import unreachable_goals

WEIGHTS = {
    Objective.MAKESPAN: (1.0, 1e-5, 1e-3, 100.0, 1e-4),
    Objective.ROBOTS: (1.0, 1e-5, 1e4, 100.0, 1e-4),
    Objective.ENERGY: (1e-2, 1.0, 1e-3, 100.0, 1e-6),
}
"""Of a second of makespan, a joule, an agent, a second of lateness, a second of all tasks' ends together."""

ROUNDING_S = 0.05
"""A makespan this close to its lower bound counts as optimal."""
MAX_ATTEMPTS = 4
"""Schedules tried, each without the unneeded stops of those before."""
ANY_SHARE = 9.0
"""Share of a path's time that a stop may take where tasks block each other: a long detour may be the only solution."""
MAX_STOPPING = 16
"""With more tasks, fragments are varied only by stops near busy places, if at all."""
MAX_DISCOVERY_S = 20.0
"""The search for fragments gets half of the time, at most this, to leave time for other engines."""
MAX_GOALS_TOGETHER = 4
"""Up to this many goals are also tried as one task if their fragments do not compose."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _RunClock:
    """Time and progress of one run."""

    begun: float
    request: PlanningRequest
    observer: Observer
    engine: str

    @property
    def elapsed_s(self) -> float:
        return time.monotonic() - self.begun

    @property
    def deadline(self) -> float:
        return self.begun + self.request.time_limit_s

    @property
    def left_s(self) -> float:
        return self.deadline - time.monotonic()

    def report_progress(self, makespan_s: float | None, bound_s: float | None = None) -> bool:
        """Report progress; False when it is time to end."""
        self.observer.progress(
            Progress(
                engine=self.engine,
                elapsed_s=round(self.elapsed_s, 3),
                makespan_s=makespan_s,
                lower_bound_s=bound_s,
            )
        )
        return not self.observer.should_stop() and time.monotonic() < self.deadline


class _CurrentProblem:
    """A problem with what is derived from it once."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self.problem = problem
        self.classes = AgentClasses(knowledge_base, problem)
        self.classifier = FactClassifier(knowledge_base, problem, self.classes)
        self.bound_s: float | None = None
        self.interacts = False
        """Some tasks block each other."""


class HierarchicalEngine:
    """Plans goals by fragments found from the knowledge base, composed by scheduling.

    Every plan-net is validated. What it cannot compose it leaves to other engines (`NOT_FOUND`); it says
    `UNSOLVABLE` only where goals contradict each other or even the delete relaxation does not reach one. A long-lived
    process calls `warm_up()` first: it imports unified-planning and compiles the inner loop (seconds, the first time).
    """

    name = "macta"
    _is_warm = False

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self._base = knowledge_base

    def warm_up(self) -> None:
        """Import and compile what is needed, once a process. A problem's time begins only after it."""
        if HierarchicalEngine._is_warm:
            return
        empty = PlanningProblem(objects={}, facts=frozenset(), goals=())
        composition = self._composition(_CurrentProblem(self._base, empty), (), PlanningRequest())
        composition.begin()
        composition.improve(1, 1.0, lambda _: True)
        self._finished((), empty)
        warm_up_bounds()
        HierarchicalEngine._is_warm = True

    @garbage_collection_paused()
    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """A plan-net, or why not."""
        self.warm_up()
        clock = _RunClock(begun=time.monotonic(), request=request, observer=observer, engine=self.name)
        return timed_result(self.name, self._base, problem, lambda: self._plan(problem, clock))

    def _plan(self, problem: PlanningProblem, clock: _RunClock) -> PlanningResult:
        if contradicting_goals(self._base, problem):
            return self._result(PlanningStatus.UNSOLVABLE, why_unsolvable(self._base, problem))
        # NOTE: learned from scratch for each problem, so that a plan-net does not depend on earlier problems.
        fragments = Fragments(self._base)
        until = clock.begun + min(clock.request.time_limit_s / 2, MAX_DISCOVERY_S)

        @cache
        def known(facts: frozenset[Fact]) -> ProblemFragments:
            return fragments.of(replace(problem, facts=facts))

        @cache
        def find(facts: frozenset[Fact], goals: Goals, *, levels: int = ALL_LEVELS) -> tuple[Fragment, ...]:
            return known(facts).alternatives(
                goals, deadline=until, levels=levels, stop=clock.observer.should_stop
            )

        current = _CurrentProblem(self._base, problem)
        return_home = ReturnHome(self._base, problem, current.classifier)
        finder = TaskFinder(problem, Groups(problem, current.classifier), return_home, find)
        tasks = finder.tasks()
        current.interacts = finder.interacts
        if clock.request.effort_s != 0.0:
            current.bound_s = lower_bound_s(self._base, problem)
        sequence: Sequence[GroundAction] | None = None
        if not isinstance(tasks, Unmet):
            sequence = self._composed(current, tasks, clock)
        if sequence is None and (chain := finder.chain()) is not None:
            sequence = self._composed(current, chain.tasks, clock) or chain.actions
            sequence = None if fault_of(sequence, problem.facts, problem.goals) else sequence
        if sequence is None and 1 < len(problem.goals) <= MAX_GOALS_TOGETHER:
            whole = find(problem.facts, problem.goals)
            sequence = whole[0].actions if whole else None
        if sequence is None:
            return self._none(problem, tasks, clock)
        return replace(self._finished(sequence, problem), lower_bound_s=current.bound_s)

    def _composed(
        self, current: _CurrentProblem, tasks: Sequence[Task], clock: _RunClock
    ) -> Sequence[GroundAction] | None:
        """A sequence, with stops where they pay; stops without an intended use (table 3) are not tried again."""
        problem = current.problem
        stops = Stops(
            knowledge_base=self._base,
            problem=problem,
            classes=current.classes,
            classifier=current.classifier,
            share=ANY_SHARE if current.interacts else SHARE,
        )
        if len(tasks) <= MAX_STOPPING:
            tasks = [replace(task, fragments=with_stops(task.fragments, stops)) for task in tasks]
        elif len(tasks) <= MAX_NEAR_STOPPING and clock.request.effort_s != 0.0:
            varied = with_near_stops([task.fragments for task in tasks], stops)
            tasks = [replace(task, fragments=some) for task, some in zip(tasks, varied, strict=True)]
        best: tuple[float, Sequence[GroundAction]] | None = None
        last = False
        for _ in range(MAX_ATTEMPTS):
            actions = self._scheduled(current, tasks, clock)
            if actions is None:
                break
            scheduled_s, idle = self._judged(actions, problem)
            makespan_s = scheduled_s
            still_idle = idle
            if idle:
                kept = [replace(task, fragments=_without(task.fragments, idle)) for task in tasks]
                last = kept == list(tasks)
                tasks = kept
                actions = without_detours(actions, problem, self._base)
                makespan_s, still_idle = self._judged(actions, problem)
            if not still_idle:
                best = min(best or (makespan_s, actions), (makespan_s, actions), key=lambda found: found[0])
            if last or (not still_idle and makespan_s <= scheduled_s):
                break
        return best[1] if best else None

    def _judged(
        self, actions: Sequence[GroundAction], problem: PlanningProblem
    ) -> tuple[float, frozenset[str]]:
        """The sequence's makespan in seconds, and its actions that table 3 does not allow."""
        net = assemble(extract(actions, problem.facts, problem.goals), problem.goals, self._base, {})
        idle = (action for action, _ in unjustified_actions(net, self._base))
        return net.makespan_s, frozenset(map(str, idle))

    def _scheduled(
        self, current: _CurrentProblem, tasks: Sequence[Task], clock: _RunClock
    ) -> Sequence[GroundAction] | None:
        problem = current.problem
        bound_s = current.bound_s
        composition = self._composition(current, tasks, clock.request)
        if not composition.begin():
            return None
        request = clock.request
        least_s = bound_s if bound_s is not None and request.objective is Objective.MAKESPAN else 0.0
        choices = sum(len(task.fragments) for task in tasks) if current.interacts else 0
        trials, seconds = effort(request, composition.legs, choices)
        composition.improve(
            trials,
            min(seconds, clock.left_s / 2),
            lambda best_s: clock.report_progress(best_s, bound_s) and best_s > least_s + ROUNDING_S,
        )
        if len(tasks) <= MAX_STOPPING:
            composition.polish()
        composed = composition.composed
        # NOTE: an agent may end where it is to be by an effect nobody intended, which does not count.
        if composed is None or fault_of(composed.actions, problem.facts, problem.goals) is not None:
            return None
        return composed.actions

    def _composition(
        self, current: _CurrentProblem, tasks: Sequence[Task], request: PlanningRequest
    ) -> Composition:
        weights: Floats = np.array(WEIGHTS[request.objective])
        return Composition(
            self._base,
            current.problem,
            current.classes,
            current.classifier,
            tasks,
            weights,
            seed=request.seed,
        )

    def _finished(self, sequence: Sequence[GroundAction], problem: PlanningProblem) -> PlanningResult:
        statics = StaticFacts(self._base, problem)
        plan_net = complete_plan_net(sequence, problem, self._base, statics)
        if isinstance(plan_net, str):
            return self._result(PlanningStatus.NOT_FOUND, plan_net)
        confirm(plan_net, problem, self._base)
        return to_result(self.name, (PlanningStatus.SOLVED, plan_net, ""))

    def _none(self, problem: PlanningProblem, tasks: object, clock: _RunClock) -> PlanningResult:
        if unreachable_goals(self._base, problem):
            return self._result(PlanningStatus.UNSOLVABLE, why_unsolvable(self._base, problem))
        if clock.observer.should_stop():
            return self._result(PlanningStatus.NOT_FOUND, "stopped before there was a plan")
        if time.monotonic() >= clock.deadline:
            return self._result(PlanningStatus.TIMED_OUT, f"no plan within {clock.request.time_limit_s:g} s")
        if isinstance(tasks, Unmet):
            named = ", ".join(map(str, tasks.goals))
            return self._result(PlanningStatus.NOT_FOUND, f"found no way to {named}")
        return self._result(PlanningStatus.NOT_FOUND, "the ways to the goals do not compose")

    def _result(self, status: PlanningStatus, reason: str) -> PlanningResult:
        return to_result(self.name, (status, None, reason))


def _without(
    fragments: Sequence[tuple[GroundAction, ...]], idle: frozenset[str]
) -> tuple[tuple[GroundAction, ...], ...]:
    """The fragments without any of these actions; the first one is always kept."""
    return (fragments[0], *(f for f in fragments[1:] if idle.isdisjoint(map(str, f))))
