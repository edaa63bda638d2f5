"""Repairs a plan-net after the world has changed, keeping its valid actions where that costs little makespan.

Plan stability after Fox, Gerevini, Long & Serina (2006, "Plan stability: replanning versus plan repair"): the
fewer actions change the better; we weigh it against the makespan.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf

from planner.engines.peripherals import attend
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.chains import begun
from planner.plan_nets.difference import Difference, compare
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.progression import apply_action
from planner.plan_nets.redundancy import without_redundant
from planner.problem.choices import keeping
from planner.problem.interface import (
    KEPT_S,
    UNOBSERVED,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.preference import PreferenceChoice, broken_cost_s, judged
from planner.problem.solving import MIN_SHARE_S, TimeLimitedEngine
from planner.repair.reinsertion import insert_new_actions
from planner.repair.remaining import MissionProgress, Remaining

OWN_NAME = "repair"
"""Name given as the engine of a plan-net that was repaired without one."""
EXPECTED_CHANGED_SHARE = 0.5
"""Expected share of the kept actions that replanning would change (our choice). A repair whose makespan is longer by
no more than these actions are worth is accepted without replanning."""
KEPT_ON_REQUEST_S = 1.0
"""Seconds of makespan that a kept action is worth where an operator asks for a better plan: the robots have stopped and
get new scripts anyway, and a saving is what is asked for."""
EXTRA_ATTEMPT_S = 1.0
EXTRA_ATTEMPT_FACTOR = 2.0
"""Time limit of a further attempt: this many seconds plus this factor times the time needed so far."""


class Course(StrEnum):
    """How a plan-net was repaired."""

    KEPT = "kept"  # the remaining actions still achieve the goals; they are only scheduled again
    MENDED = "mended"  # the executable remaining actions are kept, the other goals are planned again
    REPLANNED = "anew"  # all goals are planned again
    EDITED = "edited"  # planned again with what people have pinned (`planner.repair.pins`)
    JOINED = "joined"  # all remaining actions are kept, actions for added goals are inserted


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """The repaired plan-net, if there is one, and how it differs from the remaining actions of the old one.

    `problem` is the one it solves: the present facts, set back to before the actions under way (see `Remaining`).
    """

    course: Course
    result: PlanningResult
    problem: PlanningProblem
    difference: Difference | None = None

    @classmethod
    def of(cls, course: Course, result: PlanningResult, remaining: Remaining, planning_s: float) -> "Repair":
        """A planning result for the remaining problem, compared with the remaining actions if it has a plan-net."""
        difference = None
        if result.plan_net is not None:
            difference = compare(remaining.actions, result.plan_net, elapsed_s=remaining.progress.elapsed_s)
        result = replace(result, planning_s=round(planning_s, 4))
        return cls(course=course, result=result, problem=remaining.problem, difference=difference)

    @classmethod
    def failed(cls, course: Course, reason: str, remaining: Remaining, planning_s: float) -> "Repair":
        """No plan-net was found, for a reason other than an engine's."""
        result = PlanningResult(
            status=PlanningStatus.NOT_FOUND, engine=OWN_NAME, planning_s=planning_s, reason=reason
        )
        return cls.of(course, result, remaining, planning_s)

    @property
    def plan_net(self) -> PlanNet | None:
        return self.result.plan_net


def repair(
    engine: PlanningEngine,
    knowledge_base: KnowledgeBase,
    plan_net: PlanNet,
    problem: PlanningProblem,
    progress: MissionProgress,
    request: PlanningRequest,
    observer: Observer = UNOBSERVED,
    *,
    stability_s: float = KEPT_S,
    replans: bool = True,
    is_thorough: bool = False,
) -> Repair:
    """Plan the rest of the mission, keeping the actions under way and as many of the remaining ones as pays.

    The attempts, in order:

    1. keep all remaining actions;
    2. keep those that contribute to goals they still achieve, and plan the other goals after or in parallel to them;
    3. likewise, also keeping actions that can be executed but whose goals can no longer be achieved by the old plan;
    4. plan all goals again.

    They end with the first repair that is good enough: on time, and with a makespan of at most a lower estimate plus
    the worth of the actions that replanning is expected to change. The repair with the least lateness is returned;
    among equals the one with the shortest makespan, where each changed action counts as `stability_s`.

    :param problem: the present facts, and all the goals from now on.
    :param request: its time limit is for everything together.
    :param replans: False: without the last attempt.
    :param is_thorough: all attempts are made, though an earlier one is good enough.
    :raises UnknownAction: if the progress names actions that the plan-net lacks.
    """
    timer = request.timer()

    def repaired(stated: PlanningProblem) -> Repair:
        remaining = Remaining(plan_net, stated, progress, knowledge_base)
        left = replace(request, time_limit_s=max(timer.left_s, MIN_SHARE_S), resumes=True)
        planner = TimeLimitedEngine(engine, left, observer)
        return _PlanRepair(planner, remaining, stability_s, replans=replans, is_thorough=is_thorough).run()

    if not problem.preferences:
        return repaired(problem)
    found = _keeping_preferences(plan_net, problem, progress, repaired, stability_s)
    return replace(found, result=replace(found.result, planning_s=round(timer.elapsed_s, 4)))


def _keeping_preferences(
    plan_net: PlanNet,
    problem: PlanningProblem,
    progress: MissionProgress,
    repaired: Callable[[PlanningProblem], Repair],
    stability_s: float,
) -> Repair:
    """The repair that keeps the preferences that the plan has kept, or one by which breaking some of them pays."""
    kept = [preference for preference in problem.preferences if preference.is_kept_by(plan_net)]
    found = repaired(keeping(problem, kept))

    def sum_s(one: Repair) -> tuple[float, float]:
        if one.plan_net is None:
            return inf, inf
        changes = 0 if one.difference is None else one.difference.changes
        total_s = one.plan_net.makespan_s + broken_cost_s(problem.preferences, one.plan_net)
        return one.plan_net.late_s, total_s + stability_s * changes

    old_s = max((action.earliest_end_s for action in plan_net.actions), default=0.0) - progress.elapsed_s
    worth_s = min((preference.cost_s for preference in kept), default=inf)
    late_s, _ = sum_s(found)
    if kept and (late_s > 0 or found.plan_net is None or found.plan_net.makespan_s > old_s + worth_s):
        found = min(found, repaired(keeping(problem, ())), key=sum_s)
    if found.plan_net is None:
        return found
    outcomes = judged(
        problem.preferences, found.plan_net, otherwise="no better repair that keeps it was found"
    )
    return replace(found, result=replace(found.result, preferences=PreferenceChoice(outcomes=outcomes)))


_Candidate = tuple[Repair, PlanNet, Difference]
"""A repair that may be chosen, its plan-net and the difference from the remaining actions."""


class _PlanRepair:
    def __init__(
        self,
        planner: TimeLimitedEngine,
        remaining: Remaining,
        stability_s: float,
        *,
        replans: bool,
        is_thorough: bool,
    ) -> None:
        self._remaining = remaining
        self._stability_s = stability_s
        self._replans = replans
        self._is_thorough = is_thorough
        self._planner = planner
        self._goals = remaining.problem.goals
        progress = remaining.progress
        left = [action.earliest_end_s - progress.elapsed_s for action in remaining.actions]
        self._estimate_s = max((0.0, *left, *progress.under_way.values()))
        """Lower estimate of any plan's makespan: the remaining actions', or that of the missing goals' own plan."""

    def run(self) -> Repair:
        found: list[_Candidate] = []
        for attempt in self._attempts():
            if (repaired := attempt()) is not None:
                found.append(repaired)
                if self._is_good_enough(repaired) or self._planner.is_over:
                    break
        if not found:
            return self._failure()
        best, _, _ = min(found, key=self._cost)
        result = replace(best.result, planning_s=round(self._planner.timer.elapsed_s, 4))
        return replace(best, result=result)

    def _attempts(self) -> Iterator[Callable[[], _Candidate | None]]:
        running = self._remaining.under_way
        rest = self._remaining.rest
        if len(running) + len(rest) == len(self._remaining.actions):
            yield lambda: self._candidate(Course.KEPT, (*running, *rest))
        executable, achieved = self._executable((*running, *rest))
        contributing = without_redundant(executable, self._remaining.problem.facts, achieved)
        yield lambda: self._keep_and_plan_missing(contributing)
        if len(contributing) < len(executable):
            # Actions whose goal is no longer achieved may help a new plan, or lead to a dead end: limit the time.
            yield lambda: self._keep_and_plan_missing(
                executable, at_most_s=EXTRA_ATTEMPT_S + EXTRA_ATTEMPT_FACTOR * self._planner.timer.elapsed_s
            )
        if self._replans:
            # NOTE: a robot that has stopped between two phases goes on with none of the later ones.
            going_on, _ = self._executable(begun((*running, *rest)))
            yield lambda: self._keep_and_plan(Course.REPLANNED, going_on)

    def _executable(self, sequence: Sequence[GroundAction]) -> tuple[tuple[GroundAction, ...], list[Fact]]:
        """The actions that can be executed when the others are skipped, and the goals that they achieve."""
        problem = self._remaining.problem
        state = set(problem.facts)
        achieved = set(problem.facts)
        executable = list[GroundAction]()
        for action in attend(sequence, problem, self._remaining.knowledge_base).sequence:
            if state.issuperset(action.preconditions):
                apply_action(action, state, achieved)
                executable.append(action)
        return tuple(executable), [goal for goal in self._goals if goal in achieved]

    def _keep_and_plan_missing(
        self, kept: Sequence[GroundAction], *, at_most_s: float = inf
    ) -> _Candidate | None:
        """Keep these actions and plan what they do not achieve; None if only those under way would be kept."""
        if len(kept) == len(self._remaining.under_way):
            return None
        return self._candidate(Course.MENDED, kept) or self._keep_and_plan(
            Course.MENDED, kept, at_most_s=at_most_s
        )

    def _keep_and_plan(
        self, course: Course, kept: Sequence[GroundAction], *, at_most_s: float = inf
    ) -> _Candidate | None:
        """Insert into the kept actions a plan for all goals, made for the state after them.

        A repair uses at most half the time that is left, so that replanning has the other half.
        """
        if course is Course.MENDED:
            at_most_s = min(at_most_s, self._planner.timer.left_s / 2)
        planned = self._planner.plan(self._remaining.after(kept), at_most_s=at_most_s).plan_net
        if planned is None:
            return None
        self._estimate_s = max(self._estimate_s, planned.makespan_s)
        return self._candidate(course, insert_new_actions(kept, planned, self._remaining))

    def _candidate(self, course: Course, sequence: Sequence[GroundAction]) -> _Candidate | None:
        plan_net = self._remaining.finished(sequence, self._goals)
        if isinstance(plan_net, str):
            return None
        last = self._planner.last
        engine = last.engine if last is not None else OWN_NAME
        result = PlanningResult(
            status=PlanningStatus.SOLVED, engine=engine, planning_s=0.0, plan_net=plan_net
        )
        repaired = Repair.of(course, result, self._remaining, self._planner.timer.elapsed_s)
        assert repaired.difference is not None
        return repaired, plan_net, repaired.difference

    def _is_good_enough(self, candidate: _Candidate) -> bool:
        if self._is_thorough:
            return False
        _, plan_net, difference = candidate
        worth_s = EXPECTED_CHANGED_SHARE * self._stability_s * len(difference.kept)
        return not plan_net.late and plan_net.makespan_s <= self._estimate_s + worth_s

    def _cost(self, candidate: _Candidate) -> tuple[float, float]:
        _, plan_net, difference = candidate
        return plan_net.late_s, plan_net.makespan_s + self._stability_s * difference.changes

    def _failure(self) -> Repair:
        """The result if no attempt succeeded: the engine's last answer, which is about all goals."""
        last = self._planner.last
        if last is None or last.plan_net is not None:
            reason = "the plan found cannot follow the actions under way"
            return Repair.failed(Course.REPLANNED, reason, self._remaining, self._planner.timer.elapsed_s)
        return Repair.of(Course.REPLANNED, last, self._remaining, self._planner.timer.elapsed_s)
