from itertools import pairwise

import pytest

from robots.perception.zones import BORDER_RADIUS_M, NEAR_M, Borders
from robots.physical.body import RADIUS_M, Pose

AREA = (1.0, 3.0, -1.0, 1.0)


def test_a_border_is_closed_and_in_the_robots_frame() -> None:
    ahead = Borders([AREA]).near(Pose(x_m=0.0, y_m=0.0, heading_rad=0.0))
    assert min(point.real for point in ahead) == pytest.approx(1.0)
    assert all(abs(point) <= NEAR_M for point in ahead)
    turned = Borders([AREA]).near(Pose(x_m=2.0, y_m=-1.5, heading_rad=1.5707963267948966))
    assert min(point.real for point in turned) == pytest.approx(0.5)
    front = sorted(point.imag for point in ahead if point.real == pytest.approx(1.0))
    gaps = [high - low - 2 * BORDER_RADIUS_M for low, high in pairwise(front)]
    assert max(gaps) < RADIUS_M


def test_one_that_is_inside_may_leave_and_one_far_off_does_not_mind() -> None:
    borders = Borders([AREA])
    assert borders.near(Pose(x_m=2.0, y_m=0.0, heading_rad=0.0)) == []
    assert borders.near(Pose(x_m=-9.0, y_m=0.0, heading_rad=0.0)) == []
    assert Borders([]).near(Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)) == []


def test_the_border_of_an_area_for_one_robot_is_closed_while_another_one_is_inside() -> None:
    borders = Borders([], [AREA])
    outside = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
    assert borders.near(outside) == []
    assert borders.near(outside, [0.5 + 0j, 2.0 + 3.0j]) == []
    assert borders.near(outside, [2.0 + 0.5j]) == Borders([AREA]).near(outside)
    assert borders.near(Pose(x_m=2.0, y_m=0.5, heading_rad=0.0), [1.5 + 0j]) == []  # both may leave
