"""KICK: the robot goes round the ball and drives through it, so that it rolls to a point."""

from math import hypot

import pytest

from benchmarks.trial import Trial, packet, room
from robots.reactive.kicking import BEHIND_M, approach
from robots.wire import PacketState
from robots.world import WorldFile

TO = (5.5, 3.0)


def pitch(start: tuple[float, float, float]) -> WorldFile:
    """The ball is between the robot and the west, or the east."""
    world = room(start=start, ball=(3, 3))
    (ball,) = world.samples
    return world.model_copy(update={"samples": (ball.model_copy(update={"rolling_m_s2": 0.15}),)})


@pytest.mark.parametrize("start", [(1.5, 3, 0), (4.5, 3, 180), (3, 4.5, -90), (2.2, 1.5, 180)])
def test_a_ball_rolls_to_the_point_from_wherever_the_robot_starts(start: tuple[float, float, float]) -> None:
    order = packet("KICK", object="ball", to_x_m=TO[0], to_y_m=TO[1], timeout_s=40)
    trial = Trial(pitch(start), order, seed=1).run()
    assert trial.reports[-1].state is PacketState.FINISHED
    ball = trial.simulation.truth().samples["ball"]
    rolls_x, rolls_y = trial.simulation.scene.sample_velocity("ball")
    to_x, to_y = TO[0] - ball.x_m, TO[1] - ball.y_m
    along = (rolls_x * to_x + rolls_y * to_y) / hypot(to_x, to_y)
    assert along > 0.25
    assert along > 0.85 * hypot(rolls_x, rolls_y)


def test_a_robot_that_stands_before_the_ball_goes_round_it_on_its_own_side() -> None:
    for side in (1, -1):
        way = approach(complex(1, -0.2 * side), complex(-5, -0.2 * side))
        assert not way.is_lined_up
        assert way.aim.imag * side > 0


def test_a_robot_behind_the_ball_drives_through_it() -> None:
    way = approach(complex(0.6), complex(3))
    assert way.is_lined_up
    assert way.aim.imag == 0
    beside = approach(complex(0.3, 1.5), complex(3, 1.5))
    assert not beside.is_lined_up
    assert beside.aim == pytest.approx(complex(0.3 - BEHIND_M, 1.5))
