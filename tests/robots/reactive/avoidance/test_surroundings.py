"""The certainty grid: hits fill it, free beams clear it, it goes with the robot."""

from cmath import rect
from dataclasses import replace
from math import pi

import numpy as np
import pytest

from robots.physical.body import GRIPPER_REACH_M, Pose
from robots.reactive.avoidance import Surroundings
from robots.reactive.avoidance.surroundings import CELL_M
from tests.robots.sensed import percepts, sees

FREE = dict.fromkeys(range(16), 2.4)


def test_what_whiskers_hit_is_there_the_surer_the_longer() -> None:
    around, hit = Surroundings(), percepts(whiskers=FREE | {0: 0.8})
    sure = []
    for _ in range(4):
        around.update(hit)
        near = np.abs(around.points - 1.02) < CELL_M
        assert near.any()
        sure.append(float(around.certainty[near].max()))
    assert sure == sorted(sure)
    assert sure[-1] == 1.0


def test_what_is_no_longer_hit_is_cleared() -> None:
    around = Surroundings()
    for _ in range(4):
        around.update(percepts(whiskers=FREE | {0: 0.8}))
    for _ in range(20):
        around.update(percepts(whiskers=FREE))
    assert not (np.abs(around.points - 1.02) < CELL_M).any()


def test_what_was_hit_stays_in_its_place_while_the_robot_drives_and_turns() -> None:
    around = Surroundings()
    seen = percepts(whiskers={0: 0.8})
    for _ in range(4):
        around.update(seen)
    blind = percepts(whiskers=dict.fromkeys(range(16), 0.0))  # sees nothing beyond its hull
    around.update(replace(blind, odometry=Pose(x_m=0.5, y_m=0, heading_rad=pi / 2)))
    assert np.abs(around.points - (0.52 * -1j)).min() == pytest.approx(0, abs=CELL_M)


def test_another_robot_is_as_wide_as_it_reaches() -> None:
    around = Surroundings()
    around.update(percepts(sees("other", 1.0)))
    assert list(around.points) == [pytest.approx(1.0)]
    assert list(around.radii_m) == [GRIPPER_REACH_M]


@pytest.mark.parametrize("heading_rad", [0.0, pi / 2, pi, -pi / 2])
def test_what_is_left_behind_does_not_come_in_again_ahead(heading_rad: float) -> None:
    around, ahead = Surroundings(), rect(1.0, heading_rad)
    for _ in range(4):
        around.update(
            replace(percepts(whiskers={0: 0.8}), odometry=Pose(x_m=0.0, y_m=0.0, heading_rad=heading_rad))
        )
    assert (around.points.real > 0.9).any()
    blind = percepts(whiskers=dict.fromkeys(range(16), 0.0))
    for steps in range(8):  # half a metre farther it would be where it was, seen from there
        there = steps * 0.5 * ahead
        around.update(replace(blind, odometry=Pose(x_m=there.real, y_m=there.imag, heading_rad=heading_rad)))
    assert not (around.points.real > 0.9).any()
