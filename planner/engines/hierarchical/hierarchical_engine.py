"""The hierarchical engine behind the `PlanningEngine` seam (MACTA §6 asks for one; §4: planning and scheduling
intertwined)."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cache, cached_property

import numpy as np

from planner.bounds import lower_bound_s
from planner.bounds import warm_up as warm_up_bounds
from planner.engines.detours import without_detours
from planner.engines.garbage_collection import garbage_collection_paused
from planner.engines.hierarchical.composition import Composition, effort
from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS
from planner.engines.hierarchical.fragments.fragment import Fragment, Fragments, ProblemFragments
from planner.engines.hierarchical.legs.goal_groups import Goals
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.legs.stops import (
    MAX_NEAR_STOPPING,
    SHARE,
    Stops,
    with_near_stops,
    with_stops,
)
from planner.engines.hierarchical.scheduling_problem import Move, Task
from planner.engines.hierarchical.tasks import Arranged, TaskFinder, Unmet
from planner.engines.plan_net_completion import Outcome, complete_plan_net, confirm, timed_result
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
from planner.problem.static_facts import StaticFacts
from planner.problem.zones import holders
from planner.relaxation import closed_zones, unreachable_goals, without_ways_into

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


class HierarchicalEngine:
    """Plans goals by fragments found from the knowledge base, composed by scheduling.

    Every plan-net is validated. What it cannot compose it leaves to other engines (`NOT_FOUND`); it returns
    `UNSOLVABLE` only if goals contradict each other or even the delete relaxation does not reach one. A long-lived
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
        run = _Run(self._base, empty, PlanningRequest(), UNOBSERVED)
        composition = run.composition(())
        composition.begin()
        composition.improve(1, 1.0, lambda _: True)
        run.finished(())
        warm_up_bounds()
        HierarchicalEngine._is_warm = True

    @garbage_collection_paused()
    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """A plan-net, or why not."""
        self.warm_up()
        run = _Run(self._base, problem, request, observer)
        result = timed_result(self.name, self._base, problem, request, run.outcome)
        return replace(result, lower_bound_s=run.bound_s) if result.plan_net is not None else result


class _Run:
    """The planning of one problem."""

    def __init__(
        self,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
    ) -> None:
        self._base = knowledge_base
        self._problem = problem
        self._request = request
        self._observer = observer
        self._timer = request.timer()
        self.bound_s: float | None = None
        """The lower bound of the makespan."""
        self._interacts = False
        """Some tasks block each other."""

    @cached_property
    def _classified(self) -> ClassifiedProblem:
        return ClassifiedProblem(self._base, self._problem)

    @cached_property
    def _peripherals(self) -> Collection[str]:
        return StaticFacts(self._base, self._problem).peripherals

    def outcome(self) -> Outcome:
        problem = self._problem
        if contradicting_goals(self._base, problem):
            return PlanningStatus.UNSOLVABLE, None, why_unsolvable(self._base, problem)
        # NOTE: learned from scratch for each problem, so that a plan-net does not depend on earlier problems.
        fragments = Fragments(self._base)
        discovery_s = min(self._request.time_limit_s / 2, MAX_DISCOVERY_S)

        def is_over() -> bool:
            return self._timer.elapsed_s > discovery_s or self._observer.should_stop()

        @cache
        def known(facts: frozenset[Fact]) -> ProblemFragments:
            return fragments.of(replace(problem, facts=facts))

        @cache
        def find(facts: frozenset[Fact], goals: Goals, *, levels: int = ALL_LEVELS) -> tuple[Fragment, ...]:
            return known(self._recruiting(facts, goals)).alternatives(goals, levels=levels, is_over=is_over)

        finder = TaskFinder(self._classified, find)
        if self._request.effort_s != 0.0:
            self.bound_s = lower_bound_s(self._base, problem)
        sequence: Sequence[GroundAction] | None = None
        tasks: Sequence[Task] | Unmet = ()
        if (arranged := finder.rearranged()) is not None:
            self._interacts = True
            sequence = self._composed(arranged.tasks, arranged.moves) or self._in_order(arranged)
        if sequence is None:
            tasks = finder.tasks()
            self._interacts = finder.interacts
            if not isinstance(tasks, Unmet):
                sequence = self._composed(tasks)
        if sequence is None and (chain := finder.chain()) is not None:
            sequence = self._composed(chain.tasks) or chain.actions
            sequence = None if fault_of(sequence, problem.facts, problem.goals) else sequence
        if sequence is None and 1 < len(problem.goals) <= MAX_GOALS_TOGETHER and not problem.recruits:
            whole = find(problem.facts, problem.goals)
            sequence = whole[0].actions if whole else None
        return self._none(tasks) if sequence is None else self.finished(sequence)

    def _recruiting(self, facts: frozenset[Fact], goals: Goals) -> frozenset[Fact]:
        """The facts without the static ones about robots that are not recruited for any of these goals.

        Robots of a class are recruited for the same goals, so that scheduling keeps to what fragments have.
        """
        recruits = self._problem.recruits
        if not recruits or not all(goal in recruits for goal in goals):
            return facts
        allowed = frozenset[str]().union(*(recruits[goal] for goal in goals))
        others = self._classified.agents - allowed - frozenset(self._peripherals)
        return frozenset(
            fact for fact in facts if fact.predicate in self._base.fluents or others.isdisjoint(fact.args)
        )

    def _in_order(self, arranged: Arranged) -> Sequence[GroundAction] | None:
        """The moves as they are ordered, without stops and not improved; None if that is no plan."""
        composition = self.composition(arranged.tasks, arranged.moves)
        if not composition.begin() or composition.composed is None:
            return None
        actions = without_detours(composition.composed.actions, self._problem, self._base)
        faulty = fault_of(actions, self._problem.facts, self._problem.goals) is not None
        return None if faulty or self._judged(actions)[1] else actions

    def composition(self, tasks: Sequence[Task], moves: Sequence[Move] = ()) -> Composition:
        weights = np.array(WEIGHTS[self._request.objective])
        return Composition(self._classified, tasks, weights, self._request, moves)

    def finished(self, sequence: Sequence[GroundAction]) -> Outcome:
        problem = self._problem
        plan_net = complete_plan_net(sequence, problem, self._base, StaticFacts(self._base, problem))
        if isinstance(plan_net, str):
            return PlanningStatus.NOT_FOUND, None, plan_net
        confirm(plan_net, problem, self._base)
        return PlanningStatus.SOLVED, plan_net, ""

    def _composed(self, tasks: Sequence[Task], moves: Sequence[Move] = ()) -> Sequence[GroundAction] | None:
        """A sequence, with stops where they pay; stops without an intended use (table 3) are not tried again."""
        stops = Stops(classified=self._classified, share=ANY_SHARE if self._interacts else SHARE)
        if len(tasks) <= MAX_STOPPING:
            tasks = [replace(task, fragments=with_stops(task.fragments, stops)) for task in tasks]
        elif len(tasks) <= MAX_NEAR_STOPPING and self._request.effort_s != 0.0:
            varied = with_near_stops([task.fragments for task in tasks], stops)
            tasks = [replace(task, fragments=some) for task, some in zip(tasks, varied, strict=True)]
        best: tuple[float, Sequence[GroundAction]] | None = None
        last = False
        for _ in range(MAX_ATTEMPTS):
            actions = self._scheduled(tasks, moves)
            if actions is None:
                break
            scheduled_s, idle = self._judged(actions)
            makespan_s = scheduled_s
            still_idle = idle
            if idle:
                kept = [replace(task, fragments=_without(task.fragments, idle)) for task in tasks]
                last = kept == list(tasks)
                tasks = kept
                actions = without_detours(actions, self._problem, self._base)
                makespan_s, still_idle = self._judged(actions)
            if not still_idle:
                best = min(best or (makespan_s, actions), (makespan_s, actions), key=lambda found: found[0])
            if last or (not still_idle and makespan_s <= scheduled_s):
                break
        return best[1] if best else None

    def _judged(self, actions: Sequence[GroundAction]) -> tuple[float, frozenset[str]]:
        """The sequence's makespan in seconds, and its actions that table 3 does not allow."""
        goals = self._problem.goals
        phases = [phase for action in actions for phase in self._base.phases_of(action)]
        net = assemble(extract(phases, self._problem.facts, goals), goals, self._base, {})
        idle = (action for action, _ in unjustified_actions(net, self._base))
        return net.makespan_s, frozenset(map(GroundAction.as_whole, idle))

    def _scheduled(self, tasks: Sequence[Task], moves: Sequence[Move]) -> Sequence[GroundAction] | None:
        composition = self.composition(tasks, moves)
        if not composition.begin():
            return None
        bound_s = self.bound_s
        least_s = bound_s if bound_s is not None and self._request.objective is Objective.MAKESPAN else 0.0
        choices = sum(len(task.fragments) for task in tasks) if self._interacts else 0
        trials, seconds = effort(self._request, composition.legs, choices)
        composition.improve(
            trials,
            min(seconds, self._timer.left_s / 2),
            lambda best_s: self._go_on(best_s) and best_s > least_s + ROUNDING_S,
        )
        composed = composition.composed
        # NOTE: an agent may reach its final configuration by an effect not intended, which does not count.
        if (
            composed is None
            or fault_of(composed.actions, self._problem.facts, self._problem.goals) is not None
        ):
            return None
        return composed.actions

    def _go_on(self, makespan_s: float) -> bool:
        """Report progress; False when it is time to end."""
        self._observer.progress(
            Progress(
                engine=HierarchicalEngine.name,
                elapsed_s=round(self._timer.elapsed_s, 3),
                makespan_s=makespan_s,
                lower_bound_s=self.bound_s,
            )
        )
        return not self._observer.should_stop() and not self._timer.is_over

    def _none(self, tasks: object) -> Outcome:
        if unreachable_goals(self._base, self._problem):
            return PlanningStatus.UNSOLVABLE, None, why_unsolvable(self._base, self._problem)
        closed = closed_zones(self._base, self._problem)
        if closed and unreachable_goals(self._base, without_ways_into(self._problem, closed)):
            return PlanningStatus.UNSOLVABLE, None, ", ".join(_held(*item) for item in closed.items())
        if self._observer.should_stop():
            return PlanningStatus.NOT_FOUND, None, "stopped before there was a plan"
        if self._timer.is_over:
            return PlanningStatus.TIMED_OUT, None, f"no plan within {self._request.time_limit_s:g} s"
        if isinstance(tasks, Unmet):
            return PlanningStatus.NOT_FOUND, None, f"found no way to {', '.join(map(str, tasks.goals))}"
        return (
            PlanningStatus.NOT_FOUND,
            None,
            f"the fragments for the goals cannot be combined{self._zones_held()}",
        )

    def _zones_held(self) -> str:
        """The zones for one agent at a time that are not clear, in words; empty if all are."""
        held = [_held(*item) for item in holders(self._problem, self._base)]
        return f"; {', '.join(held)}" if held else ""


def _held(zone: str, agents: Sequence[str]) -> str:
    """`gate is held by yard_1`; without known agents only that it is not clear."""
    return f"{zone} is held by {' and '.join(agents)}" if agents else f"{zone} is not clear"


def _without(
    fragments: Sequence[tuple[GroundAction, ...]], idle: frozenset[str]
) -> tuple[tuple[GroundAction, ...], ...]:
    """The fragments without any of these actions; the first one is always kept."""
    return (fragments[0], *(f for f in fragments[1:] if idle.isdisjoint(map(str, f))))
