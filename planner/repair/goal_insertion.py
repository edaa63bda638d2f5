"""Inserts new goals into a running plan-net: committed actions are neither delayed nor changed."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import ROUNDING_S, PlanNet
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
from planner.problem.static_facts import StaticFacts
from planner.relaxation import is_relaxed_reachable
from planner.repair.difference import compare
from planner.repair.plan_repair import EXTRA_TRY_FACTOR, EXTRA_TRY_S, OWN_NAME, Course, Repair
from planner.repair.reinsertion import insert_new_actions
from planner.repair.remaining import MissionProgress, Remaining, in_order, sequence_of


def join(
    engine: PlanningEngine,
    knowledge_base: KnowledgeBase,
    plan_net: PlanNet,
    problem: PlanningProblem,
    progress: MissionProgress,
    new_goals: Sequence[Fact],
    request: PlanningRequest,
    observer: Observer = UNOBSERVED,
) -> Repair:
    """The plan-net with what the new goals take, beside and after what is committed.

    All that is left keeps its robots and their order, and starts no later than it may without the new goals. These
    are planned from where it leads to: with all robots, and with those alone that have the time; the shorter plan
    is taken.

    :param problem: the present facts; its goals do not matter.
    :param request: its time limit is for everything together.
    :raises UnknownAction: if the progress speaks of actions that the plan-net has not.
    """
    goals = tuple(dict.fromkeys((*plan_net.goals, *new_goals)))
    remaining = Remaining(plan_net, replace(problem, goals=goals), progress, knowledge_base)
    return _Joining(engine, remaining, plan_net, progress, request, observer).run()


class _Joining:
    def __init__(
        self,
        engine: PlanningEngine,
        remaining: Remaining,
        plan_net: PlanNet,
        progress: MissionProgress,
        request: PlanningRequest,
        observer: Observer,
    ) -> None:
        self._remaining = remaining
        self._old = plan_net
        self._elapsed_s = progress.elapsed_s
        self._planner = TimeLimitedEngine(engine, request, observer)
        self._why = ""

    def run(self) -> Repair:
        alone = self._alone()
        if isinstance(alone, str):
            return self._none(f"what is committed needs repair first: {alone}")
        after = self._remaining.after(sequence_of(alone))
        found = [self._joined(alone, self._planner.plan(after))]
        extra_try_s = EXTRA_TRY_S + EXTRA_TRY_FACTOR * self._planner.elapsed_s
        for busy in _busy(alone):
            idle = StaticFacts(self._remaining.knowledge_base, after).without(busy)
            if not self._planner.is_over and is_relaxed_reachable(self._remaining.knowledge_base, idle):
                found.append(self._joined(alone, self._planner.plan(idle, at_most_s=extra_try_s)))
        joined = [repair for repair in found if repair is not None]
        return min(joined, key=_merit) if joined else self._none(self._why)

    def _alone(self) -> PlanNet | str:
        """What is committed, from now on; or why it no longer works."""
        committed = (*self._remaining.under_way, *self._remaining.rest)
        if len(committed) < len(self._remaining.actions):
            return "a robot is lost, or one of its places is"
        return self._remaining.finished(committed, self._old.goals)

    def _joined(self, alone: PlanNet, answer: PlanningResult) -> Repair | None:
        """What is committed with a plan for what comes after it."""
        if answer.plan_net is None:
            self._why = self._why or answer.reason
            return None
        kept = sequence_of(alone)
        latest = {position: action.latest_start_s for position, action in enumerate(in_order(alone))}
        sequence = insert_new_actions(kept, answer.plan_net, self._remaining, starts_by_s=latest)
        plan_net = self._remaining.finished(sequence, self._remaining.problem.goals)
        if isinstance(plan_net, str) or _disturbs(plan_net, alone):
            said = plan_net if isinstance(plan_net, str) else "the new goals disturb what is committed"
            self._why = self._why or said
            return None
        result = PlanningResult(
            status=PlanningStatus.SOLVED,
            engine=answer.engine,
            planning_s=round(self._planner.elapsed_s, 4),
            plan_net=plan_net,
        )
        difference = compare(self._remaining.actions, plan_net, elapsed_s=self._elapsed_s)
        return Repair(
            course=Course.JOINED, result=result, problem=self._remaining.problem, difference=difference
        )

    def _none(self, reason: str) -> Repair:
        status = PlanningStatus.NOT_FOUND
        seconds = round(self._planner.elapsed_s, 4)
        result = PlanningResult(status=status, engine=OWN_NAME, planning_s=seconds, reason=reason)
        return Repair(course=Course.JOINED, result=result, problem=self._remaining.problem)


def _busy(alone: PlanNet) -> Iterator[frozenset[str]]:
    """The robots that are committed for more than half of the time, and all that are committed."""
    ends_s = {robot: alone.of_robot(robot)[-1].earliest_end_s for robot in alone.robots}
    late = frozenset(robot for robot, end_s in ends_s.items() if end_s > alone.makespan_s / 2)
    return iter(dict.fromkeys(busy for busy in (late, frozenset(ends_s)) if busy))


def _disturbs(joined: PlanNet, alone: PlanNet) -> bool:
    """True if something committed is done otherwise, or later than it may be."""
    kept = compare(alone.actions, joined).kept
    starts_s = {action.id: action.earliest_start_s for action in joined.actions}
    return any(
        action.id not in kept or starts_s[kept[action.id]] > action.latest_start_s + ROUNDING_S
        for action in alone.actions
    )


def _merit(repair: Repair) -> tuple[float, float, float]:
    plan_net = repair.result.plan_net
    assert plan_net is not None
    ends_s = sum(action.earliest_end_s for action in plan_net.actions)
    return sum(plan_net.late.values()), plan_net.makespan_s, ends_s
