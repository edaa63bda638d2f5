"""Where a robot holds off a place: near it, between places, out of others' way."""

from math import pi, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.perception.holding_off import APART_M, RINGS_M, hold_off_point
from robots.physical.body import RADIUS_M, Pose
from robots.physical.profile import BeaconSpec, RobotProfile

AISLE = {
    "hatch": BeaconSpec(x_m=2.0, y_m=0.0, approach_rad=(radians(90), radians(-90))),
    **{
        f"bay_{n}_{side}": BeaconSpec(
            x_m=2.0 + 1.5 * side, y_m=1.6 + 1.4 * n, approach_rad=(pi if side > 0 else 0.0,)
        )
        for n in range(3)
        for side in (-1, 1)
    },
}
HATCH = 2.0 + 0.8j
"""The hatch's approach point in the aisle."""
BAYS = [point for name, one in AISLE.items() if name != "hatch" for point in one.approach_points]


def profile(beacons: dict[str, BeaconSpec] | None = None) -> RobotProfile:
    beacons = AISLE if beacons is None else beacons
    return RobotProfile(
        name="me", start=Pose(x_m=2.0, y_m=4.0, heading_rad=0.0), beacons=beacons, others=("other",)
    )


def held_off(here: complex, *robots: complex) -> complex:
    point = hold_off_point(profile(), "hatch", here, robots)
    assert point is not None
    return point


@given(x=st.floats(1.2, 2.8), y=st.floats(2.0, 4.6))
def test_it_is_on_the_robots_side_near_the_place_and_before_no_other(x: float, y: float) -> None:
    point = held_off(complex(x, y))
    assert RINGS_M[0] - 1e-9 <= abs(point - HATCH) <= RINGS_M[-1] + 1e-9
    assert point.imag > 0
    assert min(abs(point - bay) for bay in BAYS) >= APART_M - 0.1


def test_where_another_robot_holds_off_already_it_is_elsewhere() -> None:
    here = 2.0 + 4.5j
    first = held_off(here)
    second = held_off(here, first)
    assert abs(second - first) >= 2 * RADIUS_M + 0.15
    assert abs(second - HATCH) <= RINGS_M[-1] + 1e-9


def test_a_robot_that_is_there_stays() -> None:
    point = held_off(2.0 + 4.5j)
    assert abs(held_off(point) - point) < 1e-9


def test_without_other_places_it_is_on_the_straight_way() -> None:
    alone = profile({"hatch": AISLE["hatch"]})
    point = hold_off_point(alone, "hatch", 2.0 + 4.8j, [])
    assert point == pytest.approx(2.0 + 0.8j + 1j * RINGS_M[0])


def test_an_unknown_place_has_none() -> None:
    assert hold_off_point(profile(), "elsewhere", 0j, []) is None
