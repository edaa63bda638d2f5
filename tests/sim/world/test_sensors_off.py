"""Only the sensors that run are simulated, and the battery pays for them."""

from typing import Any

import pytest

from robots.physical.body import ALL_SENSORS, Sensor
from robots.physical.energy import load_powers
from sim.bodies.battery import CHARGE_BELOW, CHARGED, Battery
from sim.physics.rays import Cut, Floats, LinesOfSight, free_shares
from sim.world.simulation import Simulation
from tests.sim.rig import run_s, simulate, two_rooms


def with_sensors(*running: Sensor, **world: Any) -> Simulation:
    simulation, _ = simulate(two_rooms(**world))
    simulation.bodies["fred"].run_sensors(frozenset(running))
    run_s(simulation, 0.1)
    return simulation


def test_a_body_runs_all_its_sensors_until_commanded_otherwise() -> None:
    simulation, _ = simulate(two_rooms())
    assert simulation.bodies["fred"].sense().by_sensor().keys() == ALL_SENSORS


@pytest.mark.parametrize("sensor", Sensor)
def test_only_the_sensors_that_run_read_anything(sensor: Sensor) -> None:
    assert with_sensors(sensor).bodies["fred"].sense().by_sensor().keys() == {sensor}


def test_no_ray_is_cast_for_a_robot_whose_sensors_are_off(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = with_sensors(second=(1.4, 0.6, 0))
    simulation.bodies["ginger"].run_sensors(frozenset({Sensor.ULTRASONIC}))
    cast: list[int] = []
    read = LinesOfSight.read

    def whisker_rays(cut: Cut, starts: Floats, ends: Floats, fans: Any) -> Floats:
        cast.append(len(starts))
        return free_shares(cut, starts, ends, fans)

    def lines_of_sight(lines: LinesOfSight, *given: Any) -> Any:
        cast.append(given[4].sum())
        return read(lines, *given)

    monkeypatch.setattr("sim.physics.sensors.free_shares", whisker_rays)
    monkeypatch.setattr(LinesOfSight, "read", lines_of_sight)
    run_s(simulation, 1 / 20)
    assert sum(cast) == 16


def test_the_bumper_keeps_a_touch_until_it_is_read() -> None:
    """A rover that drives into a wall and bounces off between two readings has touched it."""
    simulation, puppets = simulate(two_rooms((0.35, 1, 180)))
    puppets["fred"].velocity = (0.5, 0.0)
    run_s(simulation, 1.0)
    assert simulation.bodies["fred"].sense().bumper
    puppets["fred"].velocity = (-0.5, 0.0)
    run_s(simulation, 1.0)
    assert simulation.bodies["fred"].sense().bumper is False


def left_after(*running: Sensor, velocity: tuple[float, float] = (0.0, 0.0)) -> float:
    simulation, puppets = simulate(two_rooms((0.5, 1, 0)))
    simulation.bodies["fred"].run_sensors(frozenset(running))
    puppets["fred"].velocity = velocity
    run_s(simulation, 2.0)
    return simulation.bodies["fred"].sense().battery


def test_the_battery_pays_for_what_runs_and_for_driving() -> None:
    asleep, sensing, driving = left_after(), left_after(*Sensor), left_after(velocity=(0.3, 0.0))
    assert 1 > asleep > sensing > driving
    powers = load_powers()
    share = (1 - sensing) / (1 - asleep)
    expected = 1 + powers.sensing_w(ALL_SENSORS) / powers.electronics_w
    assert share == pytest.approx(expected, rel=0.1)


def test_a_low_battery_is_charged_until_it_is_nearly_full() -> None:
    battery = Battery(load_powers(), capacity_wh=120)

    def rest(hours: float, *, at_charger: bool) -> None:
        for _ in range(int(hours * 360)):
            battery.advance(10.0, running=frozenset(), driven=(0.0, 0.0), at_charger=at_charger)

    rest(1.0, at_charger=True)
    assert not battery.charging, "nearly full"
    while battery.level > CHARGE_BELOW:
        rest(1.0, at_charger=False)
    assert not battery.charging, "not at a charger"
    rest(0.1, at_charger=True)
    assert battery.charging
    rest(12.0, at_charger=True)
    assert not battery.charging
    assert battery.level > CHARGED - 0.2


def test_an_empty_battery_holds_nothing_less_than_nothing() -> None:
    battery = Battery(load_powers(), capacity_wh=120)
    battery.advance(1e9, running=ALL_SENSORS, driven=(0.5, 0.0), at_charger=False)
    assert battery.level == 0.0
