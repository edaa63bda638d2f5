"""Each condition and stimulus that data may name declares the sensors it asks for: no fewer, and no more."""

from dataclasses import MISSING, fields, replace
from typing import Any

import pytest

from robots.conditions.composition import AllOf, AnyOf, Not
from robots.conditions.own_state import Empty
from robots.conditions.position import Near
from robots.conditions.sight import InView
from robots.conditions.verdict import Condition
from robots.errors import SensorOff
from robots.perception.percepts import NOTHING, Percepts
from robots.physical.body import ALL_SENSORS, Readings, Sensor
from robots.reactive.stimuli import Proximity, Stimulus
from tests.robots.sensed import readings, sees, watch

GIVEN: dict[str, Any] = {
    "place": "bay",
    "object": "sample",
    "target": "sample",
    "other": "bay",
    "event": "goal",
    "side": 1,
    "gap_m": 0.5,
    "found": "goal",
    "keep_m": 0.5,
    "stand_off_m": 0.5,
    "within_m": 0.1,
    "sign": 1,
    "axis": "x",
    "m": 0.5,
    "s": 1.0,
    "rad": 0.5,
    "m_s": 0.2,
    "to": 0.5,
    "of": Empty(),
    "robot": "other",
    "quantity": "temperature_c",
    "x_m": 2.0,
    "y_m": 1.0,
    "x": (0.0, 2.0),
    "y": (0.0, 2.0),
}
LONG = {"object": "beam", "target": "beam@left"}
"""What a variant's fields without a default are given, by their names."""


def instance(variant: type) -> Any:
    slots = [one for one in fields(variant) if one.default is MISSING and one.default_factory is MISSING]
    assert all(one.name in GIVEN for one in slots), f"GIVEN lacks a field of {variant.__name__}"
    about = {**GIVEN, **LONG} if variant.__module__.endswith(("carrying", "long_objects")) else GIVEN
    given = {one.name: about[one.name] for one in slots}
    if variant in (AnyOf, AllOf):
        given = {"of": (Empty(), InView(target="sample"))}
    return variant(**given)


VARIANTS = [
    *(instance(variant) for variant in Condition.__subclasses__()),
    *(instance(variant) for variant in Stimulus.__subclasses__()),
    Proximity(robots=True),
    Proximity(until="bay"),
    Not(of=Near(place="bay")),
]


def with_sensors(instant: Readings, running: frozenset[Sensor]) -> Readings:
    return replace(
        instant,
        ranges_m=instant.ranges_m if Sensor.ULTRASONIC in running else None,
        bumper=instant.bumper if Sensor.BUMPER in running else None,
        sightings=instant.sightings if Sensor.INFRA_RED in running else None,
        gripper=instant.gripper if Sensor.GRIPPER in running else None,
        capture_head_m=instant.capture_head_m if Sensor.CAPTURE_HEAD in running else None,
    )


def situations(running: frozenset[Sensor]) -> list[Percepts]:
    """Far off and close by, with things about and without, and with something in the jaws."""
    instants = [
        readings(),
        readings(sees("bay", 2.0), sees("sample", 1.9), sees("other", 1.0, 0.5), whiskers={0: 0.2, 5: 1.0}),
        readings(sees("bay", 0.8), whiskers={0: 0.4}),
        readings(sees("bay", 0.8), closed=True, between="sample"),
        readings(
            sees("bay", 1.5),
            sees("beam", 0.6, 0.9, 0.9),
            sees("other", 1.0, 1.5),
            closed=True,
            between="beam",
        ),
    ]
    return [watch([with_sensors(instant, running)] * 21) for instant in instants]


def ask(variant: Any, percepts: Percepts) -> None:
    variant.check(percepts) if hasattr(variant, "check") else variant.read(percepts)


def is_told(variant: Any, percepts: Percepts) -> bool:
    try:
        ask(variant, percepts)
    except SensorOff:
        return False
    return True


@pytest.mark.parametrize(
    "variant", VARIANTS, ids=lambda variant: f"{variant.variant_name}-{len(variant.needs)}"
)
def test_a_variant_perceives_all_it_asks_for_by_the_sensors_it_declares(variant: Any) -> None:
    for percepts in situations(variant.needs):
        ask(variant, percepts)


@pytest.mark.parametrize(
    "variant", VARIANTS, ids=lambda variant: f"{variant.variant_name}-{len(variant.needs)}"
)
def test_a_variant_asks_for_each_sensor_it_declares_and_is_never_told_nothing_is_there(variant: Any) -> None:
    for sensor in variant.needs:
        told = [is_told(variant, percepts) for percepts in situations(ALL_SENSORS - {sensor})]
        assert not all(told), f"{variant.variant_name} declares {sensor} and never asks for it"


def test_the_percept_of_a_sensor_that_is_off_is_an_error_that_names_it() -> None:
    blind = watch([with_sensors(readings(), NOTHING)])
    with pytest.raises(SensorOff, match="ultrasonic"):
        _ = blind.ranges_m
    with pytest.raises(SensorOff, match="infra_red"):
        _ = blind.sightings
    with pytest.raises(SensorOff, match="ultrasonic"):
        _ = blind.obstacles


def test_whiskers_alone_do_not_tell_what_is_in_the_way() -> None:
    """A sample that is carried, or another robot, would be taken for an obstacle, or for none."""
    ultrasonic = watch([with_sensors(readings(whiskers={0: 0.2}), frozenset({Sensor.ULTRASONIC}))])
    assert ultrasonic.ranges_m[0] == 0.2
    with pytest.raises(SensorOff):
        _ = ultrasonic.obstacles
