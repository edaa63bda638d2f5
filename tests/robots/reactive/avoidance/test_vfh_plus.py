"""VFH+'s four stages are the paper's (Ulrich & Borenstein 1998)."""

from math import asin, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.physical.geometry import wrap
from robots.reactive.avoidance.vfh_plus import (
    SECTOR_RAD,
    SECTORS,
    VfhPlus,
    VfhPlusRun,
    binary,
    candidate_directions,
    free_way_m,
    masked_sectors,
)

RUN = VfhPlusRun(VfhPlus())
masks = st.lists(st.booleans(), min_size=SECTORS, max_size=SECTORS).map(np.array)
angles = st.floats(-3, 3)


def sectors(*angles_deg: float) -> set[int]:
    return {round(radians(angle) / SECTOR_RAD) % SECTORS for angle in angles_deg}


def histogram(*points: complex, certainty: float = 1.0, reach_m: float = 0.32) -> np.ndarray:
    count = len(points)
    return RUN.histogram(np.array(points), np.full(count, reach_m), np.full(count, certainty), 0.0)


def test_a_cell_covers_the_sectors_of_the_robots_width_about_it() -> None:
    covered = set(np.flatnonzero(histogram(1 + 0j)))
    half = asin(0.32)
    assert covered == {k for k in range(SECTORS) if abs(wrap(k * SECTOR_RAD)) <= half}


def test_magnitude_grows_with_nearness_and_with_the_square_of_certainty() -> None:
    assert histogram(0.5 + 0j).max() > histogram(1.0 + 0j).max() >= 1
    assert histogram(1 + 0j, certainty=0.5).max() == pytest.approx(histogram(1 + 0j).max() / 4)


def test_between_the_thresholds_a_sector_stays_as_it_was() -> None:
    values, before = np.array([0.1, 0.3, 0.3, 0.9]), np.array([True, True, False, False])
    assert binary(values, before, low=0.2, high=0.5).tolist() == [False, True, False, True]


def test_what_the_narrowest_arc_meets_masks_the_directions_behind_it() -> None:
    """At a turning radius of 0.5 m a point abeam on the left is met, so left of it is masked; right is not."""
    point, reach = np.array([0.4 + 0.4j]), np.array([0.32])
    masked = masked_sectors(point, reach, 0.0, 0.5)
    assert sectors(60, 90, 150) <= set(np.flatnonzero(masked))
    assert not sectors(0, -45, -90) & set(np.flatnonzero(masked))
    assert not masked_sectors(point, reach, 0.0, 0.0).any()


@given(masks, angles)
def test_candidates_are_free_directions_and_the_target_if_it_lies_in_a_wide_opening(
    blocked: np.ndarray, target: float
) -> None:
    for candidate in candidate_directions(blocked, target, 12):
        nearest = candidate / SECTOR_RAD
        around = {int(np.floor(nearest)) % SECTORS, int(np.ceil(nearest)) % SECTORS}
        assert not all(blocked[list(around)])
    if not blocked.any():
        assert candidate_directions(blocked, target, 12) == [target]
    if blocked.all():
        assert candidate_directions(blocked, target, 12) == []


def test_a_narrow_opening_offers_its_middle_and_a_wide_one_its_sides() -> None:
    blocked = np.ones(SECTORS, dtype=bool)
    blocked[4:7] = False
    assert candidate_directions(blocked, 0.0, 12) == [pytest.approx(5 * SECTOR_RAD)]
    blocked[20:50] = False
    assert candidate_directions(blocked, 0.0, 12)[1:] == [
        pytest.approx(wrap(26 * SECTOR_RAD)),
        pytest.approx(wrap(43 * SECTOR_RAD)),
    ]


def test_the_course_is_the_cheapest_candidate() -> None:
    """Two openings alike: the one nearer to the target, and on a tie the one chosen before."""
    blocked = np.ones(SECTORS, dtype=bool)
    blocked[sorted(sectors(-60, -55, -50) | sectors(50, 55, 60))] = False
    run = VfhPlusRun(VfhPlus())
    assert run.course(blocked, radians(10), 0.0) == pytest.approx(radians(55))
    assert run.course(blocked, radians(-10), 0.0) == pytest.approx(radians(-55))
    run.previous_rad = radians(55)
    assert run.course(blocked, 0.0, 0.0) == pytest.approx(radians(55))


def test_the_free_way_ends_where_the_hull_would_touch() -> None:
    points, reach = np.array([1 + 0.1j, 2 + 0j, -0.5 + 0j]), np.full(3, 0.3)
    assert free_way_m(points, reach) == pytest.approx(1 - (0.3**2 - 0.1**2) ** 0.5)
    assert free_way_m(np.array([0.2 + pi * 1j]), np.array([0.3])) == float("inf")
