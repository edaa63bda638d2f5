from math import hypot

import pytest

from robots.world.bodies import WheeledBodySpec
from sim.bodies.axle import STILL, Axle, Velocity
from sim.clock import TICK_S
from sim.physics.scene import ROVER_MASS_KG

NO_SLIP = (0.0, 0.0)


def roll(axle: Axle, wanted: tuple[float, float], seconds: float, now: Velocity = STILL) -> Velocity:
    """On a free floor, where the chassis keeps what velocity it is given."""
    for _ in range(round(seconds / TICK_S)):
        now = axle.roll(now, *wanted, slip=NO_SLIP)
    return now


@pytest.mark.parametrize("wanted", [(0.5, 0.0), (-0.3, 0.0), (0.0, 1.5), (0.3, -0.8)])
def test_wheels_bring_the_chassis_to_the_commanded_velocity(wanted: tuple[float, float]) -> None:
    now = roll(Axle(WheeledBodySpec()), wanted, 2)
    assert (now.ahead_m_s, now.left_m_s, now.turn_rad_s) == pytest.approx(
        (wanted[0], 0.0, wanted[1]), abs=1e-6
    )


def test_what_is_faster_than_the_wheels_keeps_its_curve() -> None:
    now = roll(Axle(WheeledBodySpec(speed_rad_s=5.0)), (1.0, 1.0), 3)
    assert now.ahead_m_s == pytest.approx(now.turn_rad_s)
    assert now.ahead_m_s + now.turn_rad_s * 0.18 == pytest.approx(5.0 * 0.07)


@pytest.mark.parametrize(
    ("measures", "most_m_s2"),
    [
        ({}, 15 * 0.07),
        ({"torque_n_m": 0.35}, 2 * 0.35 / 0.07 / ROVER_MASS_KG),
        ({"traction": 0.05}, 0.05 * 9.81 * 0.8),
    ],
    ids=["ramp", "torque", "traction"],
)
def test_ramp_torque_and_traction_each_bound_the_acceleration(
    measures: dict[str, float], most_m_s2: float
) -> None:
    now = roll(Axle(WheeledBodySpec.model_validate(measures)), (0.5, 0.0), 0.25)
    assert now.ahead_m_s / 0.25 == pytest.approx(most_m_s2, rel=0.1)


def test_on_a_slippery_floor_the_wheels_run_ahead_of_the_chassis() -> None:
    axle = Axle(WheeledBodySpec(traction=0.02))
    now = roll(axle, (0.5, 0.0), 0.5)
    assert min(axle.state.rims_m_s) > now.ahead_m_s + 0.2


def test_one_wheel_that_loses_more_of_its_turn_draws_the_chassis_to_its_side() -> None:
    now, axle = STILL, Axle(WheeledBodySpec())
    for _ in range(120):
        now = axle.roll(now, 0.5, 0.0, slip=(0.1, 0.0))
    assert now.turn_rad_s > 0.1


def test_floor_stops_a_sideways_slide_no_sooner_than_traction_allows() -> None:
    axle, now = Axle(WheeledBodySpec()), Velocity(0.0, 0.5, 0.0)
    now = axle.roll(now, 0.0, 0.0, slip=NO_SLIP)
    assert now.left_m_s == pytest.approx(0.5 - 0.7 * 9.81 * 0.8 * TICK_S)
    assert roll(axle, (0.0, 0.0), 0.2, now) == STILL


def test_a_chassis_that_is_pushed_turns_its_wheels_against_the_motors() -> None:
    axle = Axle(WheeledBodySpec(torque_n_m=0.5))
    now = axle.roll(Velocity(0.4, 0.0, 0.0), 0.0, 0.0, slip=NO_SLIP)
    assert 0.3 < now.ahead_m_s < 0.4
    assert axle.state.rims_m_s == pytest.approx((now.ahead_m_s, now.ahead_m_s))


def test_wheels_that_stand_stand_exactly() -> None:
    axle = Axle(WheeledBodySpec())
    assert roll(axle, (0.0, 0.0), 1, roll(axle, (0.5, 0.7), 1)) == STILL
    assert hypot(*axle.state.rims_m_s) == 0.0
