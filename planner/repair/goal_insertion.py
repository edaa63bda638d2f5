"""Inserts new goals into a running plan-net: committed actions are neither delayed nor changed."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_nets.difference import compare
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
from planner.repair.plan_repair import EXTRA_ATTEMPT_FACTOR, EXTRA_ATTEMPT_S, Course, Repair
from planner.repair.reinsertion import insert_new_actions
from planner.repair.remaining import MissionProgress, Remaining, in_order


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
    """Plan new goals around the actions of a plan-net that is being carried out.

    The remaining actions keep their robots and order, and start no later than their latest start without the new
    goals. The new goals are planned from the state that the remaining actions lead to: once with all robots, once with
    only those that have time; the shorter plan is taken.

    :param problem: the present facts; its goals are not used.
    :param request: its time limit is for all planning together.
    :raises UnknownAction: if the progress names an action that the plan-net does not have.
    """
    goals = tuple(dict.fromkeys((*plan_net.goals, *new_goals)))
    remaining = Remaining(plan_net, replace(problem, goals=goals), progress, knowledge_base)
    return _Joining(TimeLimitedEngine(engine, request, observer), remaining, plan_net.goals).run()


class _Joining:
    def __init__(self, planner: TimeLimitedEngine, remaining: Remaining, committed: Sequence[Fact]) -> None:
        """:param committed: the goals without the new ones."""
        self._planner = planner
        self._remaining = remaining
        self._committed = committed
        self._reason = ""

    def run(self) -> Repair:
        alone = self._alone()
        if isinstance(alone, str):
            return self._none(f"what is committed needs repair first: {alone}")
        after = self._remaining.after(in_order(alone))
        found = [self._joined(alone, self._planner.plan(after))]
        extra_try_s = EXTRA_ATTEMPT_S + EXTRA_ATTEMPT_FACTOR * self._planner.timer.elapsed_s
        for busy in _busy(alone):
            idle = StaticFacts(self._remaining.knowledge_base, after).without(busy)
            if not self._planner.is_over and is_relaxed_reachable(self._remaining.knowledge_base, idle):
                found.append(self._joined(alone, self._planner.plan(idle, at_most_s=extra_try_s)))
        joined = [repair for repair in found if repair is not None]
        return min(joined, key=_merit) if joined else self._none(self._reason)

    def _alone(self) -> PlanNet | str:
        """The remaining committed actions as a plan-net of their own, or why they can no longer be carried out."""
        committed = (*self._remaining.under_way, *self._remaining.rest)
        if len(committed) < len(self._remaining.actions):
            return "a robot is lost, or one of its places is"
        return self._remaining.finished(committed, self._committed)

    def _joined(self, alone: PlanNet, answer: PlanningResult) -> Repair | None:
        """The committed actions together with a plan for the new goals; None if there is none."""
        if answer.plan_net is None:
            self._reason = self._reason or answer.reason
            return None
        kept = in_order(alone)
        latest = {position: action.latest_start_s for position, action in enumerate(kept)}
        sequence = insert_new_actions(kept, answer.plan_net, self._remaining, starts_by_s=latest)
        plan_net = self._remaining.finished(sequence, self._remaining.problem.goals)
        if isinstance(plan_net, str) or _disturbs(plan_net, alone):
            said = plan_net if isinstance(plan_net, str) else "the new goals disturb what is committed"
            self._reason = self._reason or said
            return None
        result = PlanningResult(
            status=PlanningStatus.SOLVED, engine=answer.engine, planning_s=0.0, plan_net=plan_net
        )
        return Repair.of(Course.JOINED, result, self._remaining, self._planner.timer.elapsed_s)

    def _none(self, reason: str) -> Repair:
        return Repair.failed(Course.JOINED, reason, self._remaining, self._planner.timer.elapsed_s)


def _busy(alone: PlanNet) -> Iterator[frozenset[str]]:
    """Robots to leave out: those committed for more than half of the makespan, then all that are committed."""
    ends_s = {robot: alone.of_robot(robot)[-1].earliest_end_s for robot in alone.robots}
    late = frozenset(robot for robot, end_s in ends_s.items() if end_s > alone.makespan_s / 2)
    return iter(dict.fromkeys(busy for busy in (late, frozenset(ends_s)) if busy))


def _disturbs(joined: PlanNet, alone: PlanNet) -> bool:
    """True if a committed action is changed, or starts after its latest start."""
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
    return plan_net.late_s, plan_net.makespan_s, ends_s
