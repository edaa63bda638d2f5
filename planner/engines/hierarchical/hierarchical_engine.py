"""The hierarchical engine behind the `PlanningEngine` seam (MACTA §6 asks for one; §4: planning and scheduling
intertwined)."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property, partial
from math import inf
from operator import itemgetter

import numpy as np

from planner.bounds import lower_bound_s
from planner.bounds import warm_up as warm_up_bounds
from planner.engines.detours import without_detours
from planner.engines.garbage_collection import garbage_collection_paused
from planner.engines.hierarchical.composition import Composed, Composition, effort
from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS
from planner.engines.hierarchical.fragments.fragment import Fragment, Fragments, ProblemFragments
from planner.engines.hierarchical.legs.goal_groups import Goals
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.legs.stops import (
    MAX_NEAR_STOPPING,
    SHARE,
    Sequenced,
    Stops,
    with_near_stops,
    with_stops,
)
from planner.engines.hierarchical.scheduling_problem import Move, Task
from planner.engines.hierarchical.tasks import TaskFinder, Unmet
from planner.engines.plan_net_completion import Outcome, complete_plan_net, confirm, timed_result
from planner.errors import OrderNotKept, OutOfTime
from planner.explanation.diagnosis import why_unsolvable
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.assembly import assemble
from planner.plan_nets.difference import compare
from planner.plan_nets.extraction import extract, fault_of
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.validation import unjustified_actions
from planner.problem.contradiction import contradicting_goals
from planner.problem.interface import (
    KEPT_S,
    UNOBSERVED,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
)
from planner.problem.solving import ROUNDING_S
from planner.problem.timer import Timer
from planner.problem.zones import holders
from planner.relaxation import closed_zones, unreachable_goals, without_ways_into

WEIGHTS = {
    Objective.MAKESPAN: ((1.0, 0.0, 0.0, 100.0, 0.0), (0.0, 1e-5, 1e-3, 0.0, 1e-4)),
    Objective.ON_TIME: ((1.0, 0.0, 0.0, 100.0, 0.0), (0.0, 1e-5, 1e-3, 0.0, 1e-4)),  # what chooses is outside
    Objective.ROBOTS: ((1.0, 0.0, 1e4, 100.0, 0.0), (0.0, 1e-5, 0.0, 0.0, 1e-4)),
    Objective.ENERGY: ((1e-2, 1.0, 0.0, 100.0, 0.0), (0.0, 0.0, 1e-3, 0.0, 1e-6)),
}
"""Of a second of makespan, a joule, an agent, a second of lateness, a second of all tasks' ends together: what decides,
and what breaks ties."""

MENDING_STEP = 0.1
"""Schedules with redundant actions, or such that table 3 forbids, are mended if they are quicker by this share than the
one before."""
CHECKING_SHARE = 0.05
"""The least share of the time limit that is left for checking the plan."""
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
        self._composing_s = 0.0
        """The time that scheduling has taken: none of the search for fragments."""

    @cached_property
    def _classified(self) -> ClassifiedProblem:
        return ClassifiedProblem(self._base, self._problem)

    def outcome(self) -> Outcome:
        problem = self._problem
        if contradicting_goals(self._base, problem):
            return PlanningStatus.UNSOLVABLE, None, why_unsolvable(self._base, problem)
        # NOTE: learned from scratch for each problem, so that a plan-net does not depend on earlier problems.
        fragments = Fragments(self._base)
        discovery_s = min(self._request.time_limit_s / 2, MAX_DISCOVERY_S)

        def is_over() -> bool:
            return self._timer.elapsed_s - self._composing_s > discovery_s or self._is_over()

        @cache
        def known(facts: frozenset[Fact]) -> ProblemFragments:
            return fragments.of(replace(problem, facts=facts))

        @cache
        def find(facts: frozenset[Fact], goals: Goals, *, levels: int = ALL_LEVELS) -> tuple[Fragment, ...]:
            permitted = self._permitted(facts, goals)
            found = known(permitted).alternatives(goals, levels=levels, is_over=is_over)
            if not found and problem.recruits:  # who is not recruited may stand in the way
                driving = self._permitted(facts, goals, others_drive=True)
                if driving != permitted:
                    found = known(driving).alternatives(goals, levels=levels, is_over=is_over)
            return found

        finder = TaskFinder(self._classified, find, resumes=self._request.resumes)
        if self._request.effort_s != 0.0:
            self.bound_s = lower_bound_s(self._base, problem)
        sequence: Sequence[GroundAction] | None = None
        tasks: Sequence[Task] | Unmet = ()
        if (arranged := finder.rearranged()) is not None:
            self._interacts = True
            sequence = self._composed(arranged.tasks, arranged.moves)
        if sequence is None:
            tasks = finder.tasks()
            self._interacts = finder.interacts
            if not isinstance(tasks, Unmet):
                sequence = self._composed(tasks)
        if sequence is None and not self._is_over() and (chain := finder.chain()) is not None:
            sequence = self._composed(chain.tasks) or chain.actions
            sequence = None if fault_of(sequence, problem.facts, problem.goals) else sequence
        is_free = not problem.recruits and not problem.avoids
        together = 1 < len(problem.goals) <= MAX_GOALS_TOGETHER and is_free
        if sequence is None and together and not self._is_over():
            whole = find(problem.facts, problem.goals)
            sequence = whole[0].actions if whole else None
        return self._none(tasks) if sequence is None else self.finished(sequence)

    def _permitted(
        self, facts: frozenset[Fact], goals: Goals, *, others_drive: bool = False
    ) -> frozenset[Fact]:
        """The facts without the static ones about robots that are not recruited for any of these goals, and without
        those about places that are to be avoided for all of them.

        :param others_drive: robots that are not recruited keep those by which they come to other places.

        Robots of a class are recruited for the same goals, so that scheduling keeps to what fragments have.
        """
        problem = self._problem
        if not goals or not (problem.recruits or problem.avoids):
            return facts
        meant = [self._meant(goal) for goal in goals]
        avoided = frozenset.intersection(*(problem.avoids.get(goal, frozenset()) for goal in meant))
        if avoided:
            facts = frozenset(fact for fact in facts if avoided.isdisjoint(fact.args))
        if not all(goal in problem.recruits for goal in meant):
            return facts
        allowed = frozenset[str]().union(*(problem.recruits[goal] for goal in meant))
        others = self._classified.agents - allowed - self._classified.static_facts.peripherals
        return frozenset(
            fact
            for fact in facts
            if fact.predicate in self._base.fluents
            or others.isdisjoint(fact.args)
            or (others_drive and self._classified.static_facts.lets_drive(fact))
        )

    def _meant(self, goal: Fact) -> Fact:
        """The goal itself, or the problem's goal about the same thing, which is only put aside."""
        if goal in self._problem.goals:
            return goal
        things = self._classified.things.intersection(goal.args)
        return next((one for one in self._problem.goals if not things.isdisjoint(one.args)), goal)

    def composition(self, tasks: Sequence[Task], moves: Sequence[Move] = ()) -> Composition:
        weights = np.array(WEIGHTS[self._request.objective])
        # Only by the clock: an observer may have to look at a pipe, and is not asked for each way.
        return Composition(
            self._classified, tasks, weights, self._request, moves, lambda: self._timer.is_over
        )

    def _is_over(self) -> bool:
        return self._timer.is_over or self._observer.should_stop()

    def finished(self, sequence: Sequence[GroundAction]) -> Outcome:
        problem = self._problem
        plan_net = complete_plan_net(sequence, problem, self._base, self._classified.static_facts)
        if isinstance(plan_net, str):
            return PlanningStatus.NOT_FOUND, None, plan_net
        confirm(plan_net, problem, self._base)
        return PlanningStatus.SOLVED, plan_net, ""

    def _composed(self, tasks: Sequence[Task], moves: Sequence[Move] = ()) -> Sequence[GroundAction] | None:
        """The best sequence found that is sound; None if there is none."""
        begun_s = self._timer.elapsed_s
        try:
            return self._scheduled(tasks, moves)
        finally:
            self._composing_s += self._timer.elapsed_s - begun_s

    def _scheduled(self, tasks: Sequence[Task], moves: Sequence[Move]) -> Sequence[GroundAction] | None:
        try:
            composition = self.composition(tasks, moves)
            if not composition.begin():
                return None
        except OutOfTime:
            return None
        choices = sum(len(task.fragments) for task in tasks) if self._interacts else 0
        trials, seconds = effort(self._request, composition.legs, choices)
        timer = Timer(min(seconds, self._for_improvement_s()), self._request.clock)
        if timer.left_s > 0.0 and self._is_open(composition.best_s):
            with suppress(OutOfTime):
                composition.construct(timer.left_s, self._is_open)
                composition.vary(self._stops([task.fragments for task in tasks]))
                composition.improve(trials, timer.left_s, self._is_open)
        return self._best_plan(list(composition.found()))

    def _best_plan(self, found: Sequence[Composed]) -> Sequence[GroundAction] | None:
        """Of schedules, the best first, the first that can be carried out just as it is, or a mended one if quicker.

        Which are mended does not depend on what was found after them, so more effort never gives a worse plan.
        """
        if self._request.like is not None:
            return min(map(partial(self._kept_to, self._request.like), found), key=itemgetter(0))[1]
        best_s, best, _ = min(map(self._mended, _sparse(found)), key=itemgetter(0))
        is_makespan_all = self._request.objective is Objective.MAKESPAN and not self._problem.deadlines_s
        for composed in found:
            if is_makespan_all and composed.makespan_s >= best_s:
                break
            if self._net_as_scheduled(composed.actions) is not None:
                return composed.actions
        return best

    def _kept_to(self, like: PlanNet, composed: Composed) -> tuple[float, Sequence[GroundAction] | None]:
        """As `_mended`, with what it does not do of the plan-net to keep to counted as time."""
        makespan_s, actions, net = self._mended(composed)
        changes = 0 if net is None else compare(like.actions, net).changes
        return makespan_s + KEPT_S * changes, actions

    def _mended(self, composed: Composed) -> tuple[float, Sequence[GroundAction] | None, PlanNet | None]:
        """The makespan of a schedule's plan, its actions and its plan-net, without detours if that plan is not as
        scheduled; infinite and None if it is not a plan."""
        if (net := self._net_as_scheduled(composed.actions)) is not None:
            return composed.makespan_s, composed.actions, net
        actions = without_detours(composed.actions, self._problem, self._base)
        net = self._plan_net(actions)
        return (inf, None, None) if net is None else (net.makespan_s, actions, net)

    def _for_improvement_s(self) -> float:
        """The time that is left, less what checking the plan takes: about as long as it took to find it."""
        return self._timer.left_s - max(self._timer.elapsed_s, self._request.time_limit_s * CHECKING_SHARE)

    def _stops(self, fragments: Sequence[Sequence[Sequenced]]) -> list[Sequence[Sequenced]]:
        """For each task variants of its fragments with stops."""
        stops = Stops(classified=self._classified, share=ANY_SHARE if self._interacts else SHARE)
        if len(fragments) <= MAX_STOPPING:
            return [with_stops(some, stops)[len(some) :] for some in fragments]
        if len(fragments) <= MAX_NEAR_STOPPING:
            varied = with_near_stops(fragments, stops)
            return [more[len(some) :] for some, more in zip(fragments, varied, strict=True)]
        return [()] * len(fragments)

    def _net_as_scheduled(self, actions: Sequence[GroundAction]) -> PlanNet | None:
        """The plan-net of the sequence if it needs every action, so that it is as quick as its schedule; else None."""
        net = self._plan_net(actions)
        return net if net is not None and len(net.actions) == len(self._phases(actions)) else None

    def _plan_net(self, actions: Sequence[GroundAction]) -> PlanNet | None:
        """Of the sequence without what is redundant; None if it is not a plan or has actions that table 3 forbids.

        An agent may reach its final configuration by an effect not intended, which does not count.
        """
        goals = self._problem.goals
        if fault_of(actions, self._problem.facts, goals) is not None:
            return None
        try:
            order = extract(self._phases(actions), self._problem.facts, goals, after=self._problem.after)
        except OrderNotKept:
            return None
        net = assemble(order, goals, self._base, {})
        return None if unjustified_actions(net, self._base) else net

    def _phases(self, actions: Sequence[GroundAction]) -> list[GroundAction]:
        return [phase for action in actions for phase in self._base.phases_of(action, self._problem.facts)]

    def _is_open(self, makespan_s: float) -> bool:
        """Report progress; False if the plan is the best there can be or it is time to end."""
        least_s = (self.bound_s or 0.0) if self._request.objective is Objective.MAKESPAN else 0.0
        return self._go_on(makespan_s) and makespan_s > least_s + ROUNDING_S

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


def _sparse(found: Sequence[Composed]) -> Iterator[Composed]:
    """The last one, which was found first, and each that is a good deal quicker than the one before it."""
    last_s = inf
    for composed in reversed(found):
        if composed.makespan_s <= last_s * (1.0 - MENDING_STEP):
            last_s = composed.makespan_s
            yield composed
