"""Repairs a plan-net after the world has changed; valid actions are kept as far as that pays.

Plan stability after Fox, Gerevini, Long & Serina (2006, "Plan stability: replanning versus plan repair"): the
fewer actions change the better; we weigh it against the makespan.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf

from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.progression import apply_action
from planner.plan_nets.redundancy import without_redundant
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.solving import TimeLimitedEngine
from planner.repair.difference import Difference, compare
from planner.repair.reinsertion import insert_new_actions
from planner.repair.remaining import MissionProgress, Remaining

STABILITY_S = 5.0
"""Seconds of makespan that one kept action is worth, unless told. Our choice: about what a robot needs to release a
sample; who has approved a plan wants a reason for each change."""
OWN_NAME = "repair"
"""The engine named by a plan-net that needed no engine."""
EXPECTED_CHANGED_SHARE = 0.5
"""Expected share of the kept actions that replanning would change; a repair may be worse by their worth."""
EXTRA_TRY_S = 1.0
EXTRA_TRY_FACTOR = 2.0
"""Time limit of a further attempt: this many seconds plus this factor times the time needed so far."""


class Course(StrEnum):
    """How a plan-net was repaired."""

    KEPT = "kept"  # what was left still reaches the goals; it is only scheduled again
    MENDED = "mended"  # what still works is kept, the goals that it misses are planned again
    ANEW = "anew"  # all goals are planned again
    JOINED = "joined"  # all that was left is kept, goals have been added


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """The repaired plan-net, if there is one, and how it differs from what was left of the old one.

    `problem` is the one it solves: the present facts, as of when what is under way began.
    """

    course: Course
    result: PlanningResult
    problem: PlanningProblem
    difference: Difference | None = None

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
    stability_s: float = STABILITY_S,
) -> Repair:
    """A plan-net from now on that keeps what is done, what is under way, and as much of the rest as pays.

    Tried in turn: the rest as it is; what leads to those goals that it still reaches, the others planned after that
    and beside it where they can be; the same with the beginnings of what leads to no goal any longer; all goals again.
    The next is tried unless the one before is good enough: no longer than any plan is expected to take at least, and
    what planning again would change. The best is the one least late, then with the shortest makespan, each changed
    action counting `stability_s`.

    :param problem: the present facts, and all the goals from now on.
    :param request: its time limit is for everything together.
    :raises UnknownAction: if the progress speaks of actions that the plan-net has not.
    """
    remaining = Remaining(plan_net, problem, progress, knowledge_base)
    return _PlanRepair(engine, remaining, progress, request, observer, stability_s).run()


@dataclass(frozen=True, slots=True, kw_only=True)
class _RepairedPlan:
    """A plan-net to choose."""

    course: Course
    engine: str
    plan_net: PlanNet
    difference: Difference


class _PlanRepair:
    def __init__(
        self,
        engine: PlanningEngine,
        remaining: Remaining,
        progress: MissionProgress,
        request: PlanningRequest,
        observer: Observer,
        stability_s: float,
    ) -> None:
        self._remaining = remaining
        self._progress = progress
        self._stability_s = stability_s
        self._planner = TimeLimitedEngine(engine, request, observer)
        self._goals = remaining.problem.goals
        left = [action.earliest_end_s - progress.elapsed_s for action in remaining.actions]
        self._least_s = max((0.0, *left, *progress.under_way.values()))
        """The least that any plan is expected to take: what was left, and what is missing if planned by itself."""

    def run(self) -> Repair:
        found: list[_RepairedPlan] = []
        for attempt in self._attempts():
            if (repaired := attempt()) is not None:
                found.append(repaired)
                if self._is_good_enough(repaired) or self._planner.is_over:
                    break
        return self._repair(min(found, key=self._merit)) if found else self._none()

    def _attempts(self) -> Iterator[Callable[[], _RepairedPlan | None]]:
        running = self._remaining.under_way
        rest = self._remaining.rest
        if len(running) + len(rest) == len(self._remaining.actions):
            yield lambda: self._made(Course.KEPT, (*running, *rest))
        able, achieved = self._able((*running, *rest))
        bare = without_redundant(able, self._remaining.problem.facts, achieved)
        yield lambda: self._repaired(bare)
        if len(bare) < len(able):
            # The beginnings of what has no end may be of use; or lead where no way leads on.
            yield lambda: self._repaired(
                able, at_most_s=EXTRA_TRY_S + EXTRA_TRY_FACTOR * self._planner.elapsed_s
            )
        yield lambda: self._followed(Course.ANEW, running)

    def _able(self, sequence: Sequence[GroundAction]) -> tuple[tuple[GroundAction, ...], list[Fact]]:
        """The actions that can be carried out though others cannot, and the goals that are achieved then."""
        facts = self._remaining.problem.facts
        state = set(facts)
        achieved = set(facts)
        able = list[GroundAction]()
        for action in sequence:
            if state.issuperset(action.preconditions):
                apply_action(action, state, achieved)
                able.append(action)
        return tuple(able), [goal for goal in self._goals if goal in achieved]

    def _repaired(self, kept: Sequence[GroundAction], *, at_most_s: float = inf) -> _RepairedPlan | None:
        """What is kept, then what it misses; to keep nothing but what is under way is to plan again."""
        if len(kept) == len(self._remaining.under_way):
            return None
        return self._made(Course.MENDED, kept) or self._followed(Course.MENDED, kept, at_most_s=at_most_s)

    def _followed(
        self, course: Course, kept: Sequence[GroundAction], *, at_most_s: float = inf
    ) -> _RepairedPlan | None:
        """The kept actions with a plan for all goals from where they lead to. Planning again is left half the time."""
        if course is Course.MENDED:
            at_most_s = min(at_most_s, self._planner.left_s / 2)
        fresh = self._planner.plan(self._remaining.after(kept), at_most_s=at_most_s).plan_net
        if fresh is None:
            return None
        self._least_s = max(self._least_s, fresh.makespan_s)
        return self._made(course, insert_new_actions(kept, fresh, self._remaining))

    def _made(self, course: Course, sequence: Sequence[GroundAction]) -> _RepairedPlan | None:
        plan_net = self._remaining.finished(sequence, self._goals)
        if isinstance(plan_net, str):
            return None
        difference = compare(self._remaining.actions, plan_net, elapsed_s=self._progress.elapsed_s)
        asked = self._planner.last
        engine = asked.engine if asked is not None else OWN_NAME
        return _RepairedPlan(course=course, engine=engine, plan_net=plan_net, difference=difference)

    def _is_good_enough(self, repaired: _RepairedPlan) -> bool:
        worth_s = EXPECTED_CHANGED_SHARE * self._stability_s * len(repaired.difference.kept)
        return not repaired.plan_net.late and repaired.plan_net.makespan_s <= self._least_s + worth_s

    def _merit(self, repaired: _RepairedPlan) -> tuple[float, float]:
        changed_s = self._stability_s * repaired.difference.changes
        return sum(repaired.plan_net.late.values()), repaired.plan_net.makespan_s + changed_s

    def _repair(self, repaired: _RepairedPlan) -> Repair:
        result = PlanningResult(
            status=PlanningStatus.SOLVED,
            engine=repaired.engine,
            planning_s=round(self._planner.elapsed_s, 4),
            plan_net=repaired.plan_net,
        )
        return Repair(
            course=repaired.course,
            result=result,
            problem=self._remaining.problem,
            difference=repaired.difference,
        )

    def _none(self) -> Repair:
        """No plan-net: as the engine said, which was asked for all goals last."""
        said = self._planner.last
        if said is None or said.plan_net is not None:
            reason = "the plan found does not follow on what is under way"
            said = PlanningResult(
                status=PlanningStatus.NOT_FOUND, engine=OWN_NAME, planning_s=0.0, reason=reason
            )
        result = replace(said, planning_s=round(self._planner.elapsed_s, 4))
        return Repair(course=Course.ANEW, result=result, problem=self._remaining.problem)
