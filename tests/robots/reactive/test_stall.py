"""A packet that makes no progress: it stalls, backs off, turns, and is given up after some retries."""

from dataclasses import replace

import pytest

from robots.perception.percepts import Percepts
from robots.physical.body import Pose
from robots.reactive.patterns import Responses, respond
from robots.reactive.stall import STALLED_S, StallGuard
from robots.reactive.synthesis import Motion, motion
from robots.repertoire import load_repertoire
from tests.robots.sensed import percepts

STEP_S = 0.1
HERE = percepts()
SPEED_M_S = 0.5
TURN_RAD_S = 1.5
CONTENT = load_repertoire().specs["NAVIGATE"].bind({})
BACK_OFF_S = 1.6


def stall(guard: StallGuard, instant: Percepts = HERE) -> None:
    """Watch a robot that does not move until the guard says that it has stalled."""
    for _ in range(round(STALLED_S / STEP_S) + 2):
        guard.watch(instant, STEP_S)
    assert guard.stalled


def manoeuvre(guard: StallGuard, instant: Percepts = HERE) -> list[Responses]:
    guard.retry(manoeuvre=True)
    responses = []
    while (progress := guard.manoeuvre(STEP_S, CONTENT.retry_s)) is not None:
        instant.progress = progress
        responses.append(respond(CONTENT.retry, instant))
    return responses


def motions(responses: list[Responses]) -> list[Motion]:
    return [motion(one.resultant, speed_m_s=SPEED_M_S, turn_rad_s=TURN_RAD_S) for one in responses]


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
    driven = motions(manoeuvre(StallGuard(goal=None)))
    back = [one for one in driven if one.linear_m_s < 0]
    turns = [one for one in driven if abs(one.angular_rad_s) > 0]
    assert driven == [*back, *turns]
    assert {round(one.linear_m_s, 9) for one in back} == {-0.4 * SPEED_M_S}
    assert len(back) * STEP_S == pytest.approx(BACK_OFF_S, abs=2 * STEP_S)
    assert len(turns) * STEP_S == pytest.approx(CONTENT.retry_s - BACK_OFF_S, abs=2 * STEP_S)


def test_its_patterns_are_told_as_those_of_any_motion() -> None:
    shown = manoeuvre(StallGuard(goal=None))[0].shown()
    assert shown["translate/retreat"] == pytest.approx((-0.4, 1.0))
    assert shown["rotate/turn_aside"] == (0.0, 0.0)


def test_it_turns_right_first_and_to_the_other_side_with_every_retry() -> None:
    """To the right first, as robots that meet pass each other on the right."""
    guard = StallGuard(goal=None)
    sides = [motions(manoeuvre(guard))[-1].angular_rad_s for _ in range(3)]
    assert sides == pytest.approx([-0.5 * TURN_RAD_S, 0.5 * TURN_RAD_S, -0.5 * TURN_RAD_S])


@pytest.mark.parametrize("gap_m", [0.0, 0.05, 0.12])
def test_it_does_not_back_off_into_what_is_behind(gap_m: float) -> None:
    behind = percepts(whiskers={8: gap_m})
    driven = motions(manoeuvre(StallGuard(goal=None), behind))
    assert all(abs(one.linear_m_s) < 0.005 for one in driven)


def test_it_backs_off_slowly_towards_what_is_farther_behind() -> None:
    driven = motions(manoeuvre(StallGuard(goal=None), percepts(whiskers={8: 0.2})))
    assert -0.4 * SPEED_M_S < driven[0].linear_m_s < -0.01


def test_without_a_manoeuvre_a_retry_is_only_counted() -> None:
    guard = StallGuard(goal=None)
    stall(guard)
    guard.retry(manoeuvre=False)
    assert (guard.state.retries, guard.stalled, guard.manoeuvring) == (1, False, False)


def test_it_is_spent_once_it_stalls_after_the_last_retry() -> None:
    guard = StallGuard(goal=None, retries=1)
    stall(guard)
    assert not guard.spent
    manoeuvre(guard)
    assert not guard.stalled
    stall(guard)
    assert guard.spent
