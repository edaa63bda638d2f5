from math import pi

import pytest

from robots.physical.geometry import wrap


@pytest.mark.parametrize("turns", [-3, -1, 1, 3])
def test_half_a_turn_either_way_is_plus_pi(turns: int) -> None:
    assert wrap(turns * pi) == pi


@pytest.mark.parametrize("turns", [-2, -1, 1, 2])
def test_whole_turns_change_no_angle(turns: int) -> None:
    for angle_rad in (-3.0, -0.5, 0.0, 0.5, 3.0):
        assert wrap(angle_rad + turns * 2 * pi) == pytest.approx(angle_rad)
