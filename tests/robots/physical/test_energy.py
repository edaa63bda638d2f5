"""What sensing costs is counted from checked data."""

import pytest
from pydantic import ValidationError

from robots.physical.body import ALL_SENSORS, Sensor
from robots.physical.energy import Powers, SensingMeter, load_powers

ROUND = Powers.model_validate(
    {
        "electronics_w": 1,
        "charger_w": 20,
        "motors": {"per_m_s": 30, "per_rad_s": 6},
        "sensors": dict.fromkeys(ALL_SENSORS, 2.0),
    }
)


def test_used_and_saved_add_up_to_all_sensors_all_the_time() -> None:
    meter = SensingMeter(ROUND)
    meter.count(frozenset({Sensor.BUMPER, Sensor.GRIPPER}), 5.0)
    meter.count(frozenset(), 5.0)
    assert meter.used_j == pytest.approx(2 * 2.0 * 5.0)
    assert meter.used_j + meter.saved_j == pytest.approx(len(ALL_SENSORS) * 2.0 * 10.0)


def test_driving_costs_by_speed_either_way() -> None:
    assert ROUND.driving_w(-0.5, 1.0) == pytest.approx(21)
    assert ROUND.driving_w(0.0, 0.0) == 0


def test_the_shipped_powers_name_every_sensor() -> None:
    assert load_powers().sensors.keys() == ALL_SENSORS


@pytest.mark.parametrize(
    ("changed", "names"),
    [
        ({"capacity_wh": 10}, "capacity_wh"),
        ({"electronics_w": -1}, "electronics_w"),
        ({"sensors": {"bumper": 1}}, "the power is missing of capture_head"),
        ({"wings_w": 1}, "wings_w"),
    ],
)
def test_powers_that_cannot_be_are_refused_by_name(changed: dict[str, object], names: str) -> None:
    with pytest.raises(ValidationError, match=names):
        Powers.model_validate(ROUND.model_dump() | changed)
