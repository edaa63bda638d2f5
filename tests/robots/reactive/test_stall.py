"""A packet that makes no progress: it stalls, backs off, turns, and is given up after some retries."""

from dataclasses import replace

import pytest

from robots.perception.percepts import Percepts
from robots.physical.body import Pose
from robots.reactive.stall import BACK_OFF_S, STALLED_S, TURN_S, StallGuard
from robots.reactive.synthesis import Motion
from tests.robots.sensed import percepts

STEP_S = 0.1
HERE = percepts()
SPEED_M_S = 0.5
TURN_RAD_S = 1.5


def stall(guard: StallGuard, instant: Percepts = HERE) -> None:
    """Watch a robot that does not move until the guard says that it has stalled."""
    for _ in range(round(STALLED_S / STEP_S) + 2):
        guard.watch(instant, STEP_S)
    assert guard.stalled


def manoeuvre(guard: StallGuard, instant: Percepts = HERE) -> list[Motion]:
    guard.begin_manoeuvre()
    motions = []
    while (motion := guard.manoeuvre(instant, STEP_S, SPEED_M_S, TURN_RAD_S)) is not None:
        motions.append(motion)
    return motions


def test_a_robot_that_does_not_move_stalls() -> None:
    guard = StallGuard(goal=None)
    for _ in range(round(0.8 * STALLED_S / STEP_S)):
        guard.watch(HERE, STEP_S)
    assert not guard.stalled
    stall(guard)


def test_a_robot_that_moves_does_not_stall() -> None:
    guard = StallGuard(goal=None)
    for tick in range(round(2 * STALLED_S / STEP_S)):
        guard.watch(replace(HERE, pose=Pose(x_m=0.02 * tick, y_m=0, heading_rad=0)), STEP_S)
    assert not guard.stalled


def test_the_manoeuvre_backs_off_then_turns() -> None:
    motions = manoeuvre(StallGuard(goal=None))
    back = [motion for motion in motions if motion.linear_m_s < 0]
    turns = [motion for motion in motions if motion.angular_rad_s != 0]
    assert motions == [*back, *turns]
    assert len(back) * STEP_S == pytest.approx(BACK_OFF_S, abs=2 * STEP_S)
    assert len(turns) * STEP_S == pytest.approx(TURN_S, abs=2 * STEP_S)


def test_it_turns_right_first_and_to_the_other_side_with_every_retry() -> None:
    """To the right first, as robots that meet pass each other on the right."""
    guard = StallGuard(goal=None)
    sides = [manoeuvre(guard)[-1].angular_rad_s for _ in range(3)]
    assert sides == [-0.5 * TURN_RAD_S, 0.5 * TURN_RAD_S, -0.5 * TURN_RAD_S]


def test_it_does_not_back_off_into_what_is_behind() -> None:
    behind = percepts(whiskers={8: 0.05})
    assert all(motion.linear_m_s == 0 for motion in manoeuvre(StallGuard(goal=None), behind))


def test_it_is_spent_once_it_stalls_after_the_last_retry() -> None:
    guard = StallGuard(goal=None, retries=1)
    stall(guard)
    assert not guard.spent
    manoeuvre(guard)
    assert not guard.stalled
    stall(guard)
    assert guard.spent
