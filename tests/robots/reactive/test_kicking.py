"""The way to a ball that is to be kicked: through it from behind, round it from before it."""

from cmath import rect
from math import pi

import numpy as np
import pytest

from robots.reactive.kicking import BEHIND_M, CLEAR_M, approach

PLACES = [
    rect(away_m, angle) for away_m in (0.8, 1.2, 2.5, 6.0) for angle in np.arange(-pi, pi, pi / 36) + 0.01
]
"""Where a robot stands relative to the ball, which is to roll along the x axis."""


def seen_from(place: complex, heading_rad: float) -> tuple[complex, complex]:
    """The ball and where it is to roll, 5 m on, in the frame of a robot."""
    ahead = rect(1.0, -heading_rad)
    return -place * ahead, (5.0 - place) * ahead


def passes_m(place: complex) -> float:
    """How near the straight way from there to behind the ball passes it."""
    return float(np.min(np.abs(np.linspace(place, -BEHIND_M, 1000))))


@pytest.mark.parametrize("heading_rad", [0.0, 2.0])
def test_a_robot_drives_straight_behind_the_ball_unless_that_leads_past_it_too_near(
    heading_rad: float,
) -> None:
    straight = round_it = 0
    for place in PLACES:
        ball, to = seen_from(place, heading_rad)
        way = approach(ball, to)
        if way.is_lined_up or abs(passes_m(place) - CLEAR_M) < 0.01:
            continue
        # Where it drives, relative to the ball.
        aim = way.aim * rect(1.0, heading_rad) + place
        if passes_m(place) > CLEAR_M:
            assert aim == pytest.approx(-BEHIND_M)
            straight += 1
        else:
            assert (aim.real < 0, abs(aim.imag) > CLEAR_M, aim.imag * place.imag > 0) == (True, True, True)
            round_it += 1
    assert min(straight, round_it) > 50


def test_a_robot_behind_the_ball_drives_through_it() -> None:
    way = approach(*seen_from(-1.0 + 0.1j, 0.0))
    assert way.is_lined_up
    assert way.aim == pytest.approx(0.5 - 0.1j)  # half a metre ahead, on the line


def test_a_robot_before_the_ball_is_not_lined_up() -> None:
    assert not approach(*seen_from(1.0 + 0j, 0.0)).is_lined_up
