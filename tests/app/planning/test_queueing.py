"""The queue and the rank of planning jobs."""

from typing import Any, cast

import pytest

from app.planning.pool.waiting_line import Priority
from app.planning.queueing import SLOT_S, PlanningQueues, queue_of
from app.store import GoalRow
from app.workflows import LARGE_PLANNING, PLANNING, Queue, Workflows
from tests.app.stepped_clock import SteppedClock

GOAL = Priority.GOAL


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock()


@pytest.fixture
def queues(clock: SteppedClock) -> PlanningQueues:
    return PlanningQueues(cast("Workflows", None), clock=clock)


def test_a_world_with_many_goals_delays_another_world_by_one_at_most(queues: PlanningQueues) -> None:
    many = [queues.rank(GOAL, "busy") for _ in range(100)]
    assert many == sorted(set(many))
    assert many[0] <= queues.rank(GOAL, "calm") < many[2]


def test_no_later_job_of_another_world_overtakes_for_ever(
    queues: PlanningQueues, clock: SteppedClock
) -> None:
    last = [queues.rank(GOAL, "busy") for _ in range(10)][-1]
    clock.advance(11 * SLOT_S)
    assert queues.rank(GOAL, "calm") > last


def test_repairs_are_before_all_goals_and_alternatives_after_them(
    queues: PlanningQueues, clock: SteppedClock
) -> None:
    goals = [queues.rank(GOAL, "a") for _ in range(10)]
    alternatives = queues.rank(Priority.ALTERNATIVES, "a")
    clock.advance(1e6)
    assert queues.rank(Priority.RECOVERY, "a") < min(goals)
    assert queues.rank(GOAL, "a") < alternatives


@pytest.mark.parametrize("epoch_s", [0.0, 1.8e9, 1e10])
def test_ranks_are_what_the_queue_takes_whatever_the_clock_says(epoch_s: float) -> None:
    queues = PlanningQueues(cast("Workflows", None), clock=SteppedClock(epoch_s=epoch_s))
    for priority in Priority:
        assert 1 <= queues.rank(priority, "a") <= 2**31 - 1


@pytest.mark.parametrize(
    ("goals", "limits", "queue"),
    [
        (8, {"effort_s": None}, PLANNING),
        (9, {}, LARGE_PLANNING),
        (1, {"effort_s": 30.0}, LARGE_PLANNING),
    ],
)
def test_large_problems_wait_in_a_queue_of_their_own(
    goals: int, limits: dict[str, Any], queue: Queue
) -> None:
    goal = GoalRow(goal=[{"predicate": "in", "args": []}] * goals, limits=limits)
    assert queue_of(goal) is queue
