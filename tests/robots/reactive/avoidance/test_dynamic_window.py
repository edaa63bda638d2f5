"""The dynamic window is the paper's (Fox, Burgard & Thrun 1997)."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.reactive.avoidance import DynamicWindow, Velocity, Wanted
from robots.reactive.avoidance.dynamic_window import DynamicWindowRun, clearance_m

SETTINGS = DynamicWindow()
RUN = DynamicWindowRun(SETTINGS)
LIMITS = Velocity(0.5, 1.5)


def clear(
    linear: float, angular: float, point: complex, *, reach_m: float = 0.32, coast: float = 0.0
) -> float:
    one = np.array([[linear]])
    return float(
        clearance_m(
            one, np.full((1, 1), angular), np.full((1, 1), coast), np.array([point]), np.array([reach_m])
        )[0, 0]
    )


@given(
    st.floats(0.05, 0.5),
    st.floats(-1.5, 1.5),
    st.floats(0.4, 2.0),
    st.floats(-pi, pi),
)
def test_clearance_is_the_way_along_the_arc_until_the_hull_touches(
    linear: float, angular: float, away_m: float, around: float
) -> None:
    """Held against driving the arc in small steps, once round at most."""
    point, reach_m = away_m * complex(np.cos(around), np.sin(around)), 0.32
    step_m = 0.002
    heading, at, driven = 0.0, 0j, 0.0
    whole_m = min(6.0, 2 * pi * linear / max(abs(angular), 1e-9))
    while driven < whole_m and abs(point - at) > reach_m:
        turn = angular / linear * step_m
        at += step_m * complex(np.cos(heading + turn / 2), np.sin(heading + turn / 2))
        heading += turn
        driven += step_m
    got = clear(linear, angular, point)
    if driven < whole_m:
        assert got == pytest.approx(driven, abs=0.05) or grazes(linear, angular, point, reach_m)
    elif whole_m < 6.0:
        assert got == np.inf or grazes(linear, angular, point, reach_m)


def grazes(linear: float, angular: float, point: complex, reach_m: float) -> bool:
    """The arc passes the point so closely at the reach that a step decides."""
    if abs(angular) < 1e-3:
        return True
    radius = linear / angular
    return abs(abs(abs(point - 1j * radius) - abs(radius)) - reach_m) < 0.01


def test_a_turn_on_the_spot_is_worth_the_way_ahead_after_it() -> None:
    assert clear(0, 1.0, 1 + 0j, coast=0.0) == pytest.approx(0.68)
    assert clear(0, 1.0, 1 + 0j, coast=pi / 2) == np.inf


def test_the_window_holds_what_can_be_reached_within_limits() -> None:
    wanted = Wanted(direction_rad=0, pace_m_s=0.5, limits=LIMITS)
    linear, angular = RUN.window(Velocity(0.4, 1.0), wanted)
    gain, turn = (
        SETTINGS.acceleration_m_s2 * SETTINGS.window_s,
        SETTINGS.turn_acceleration_rad_s2 * SETTINGS.window_s,
    )
    assert linear.min() == pytest.approx(0.4 - gain)
    assert linear.max() == pytest.approx(0.5)
    assert angular.min() == pytest.approx(1.0 - turn)
    assert angular.max() == pytest.approx(1.5)


def test_only_velocities_that_can_stop_in_time_are_admissible() -> None:
    speeds = np.array([[0.1, 0.3, 0.5]])
    clear_m = np.full((1, 3), 0.3**2 / 2)
    assert RUN.admissible(speeds, np.zeros((1, 3)), clear_m).tolist() == [[True, True, False]]


@given(st.floats(-1, 1))
def test_in_the_open_it_heads_for_the_direction_wanted_at_full_pace(direction: float) -> None:
    wanted = Wanted(direction_rad=direction, pace_m_s=0.5, limits=LIMITS)
    linear, angular = RUN.window(Velocity(0.4, 0.0), wanted)
    coast = RUN.coast(angular)
    value = RUN.objective(linear, coast, np.full(linear.shape, 1.0), wanted)
    row, column = np.unravel_index(int(np.argmax(value)), value.shape)
    assert linear[row, column] == pytest.approx(0.5)
    if abs(direction) > 0.3:
        assert angular[row, column] * direction > 0
    assert coast[row, column] == pytest.approx(np.clip(direction, coast.min(), coast.max()), abs=0.35)
