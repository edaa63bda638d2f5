"""Each word that data may name declares the sensors it asks for: no fewer, and no more."""

from dataclasses import MISSING, fields, replace
from typing import Any, get_args

import pytest

from robots.conditions.composition import AllOf, AnyCondition, AnyOf, Not
from robots.conditions.own_state import Empty
from robots.conditions.position import Near
from robots.conditions.sight import InView
from robots.errors import SensorOff
from robots.perception.percepts import NOTHING, Percepts
from robots.physical.body import ALL_SENSORS, Readings, Sensor
from robots.reactive.stimuli import AnyStimulus, Proximity
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
}
LONG = {"object": "beam", "target": "beam@left"}
"""What a word's fields without a default are given, by their names."""


def words(union: Any) -> list[type]:
    return list(get_args(get_args(union)[0]))


def instance(word: type) -> Any:
    slots = [one for one in fields(word) if one.default is MISSING and one.default_factory is MISSING]
    assert all(one.name in GIVEN for one in slots), f"GIVEN lacks a field of {word.__name__}"
    about = {**GIVEN, **LONG} if word.__module__.endswith(("carrying", "long_objects")) else GIVEN
    given = {one.name: about[one.name] for one in slots}
    if word in (AnyOf, AllOf):
        given = {"of": (Empty(), InView(target="sample"))}
    return word(**given)


WORDS = [
    *(instance(word) for word in words(AnyCondition)),
    *(instance(word) for word in words(AnyStimulus)),
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


def ask(word: Any, percepts: Percepts) -> None:
    word.check(percepts) if hasattr(word, "check") else word.read(percepts)


def is_told(word: Any, percepts: Percepts) -> bool:
    try:
        ask(word, percepts)
    except SensorOff:
        return False
    return True


@pytest.mark.parametrize("word", WORDS, ids=lambda word: f"{word.sense}-{len(word.needs)}")
def test_a_word_is_told_all_it_asks_for_by_the_sensors_it_declares(word: Any) -> None:
    for percepts in situations(word.needs):
        ask(word, percepts)


@pytest.mark.parametrize("word", WORDS, ids=lambda word: f"{word.sense}-{len(word.needs)}")
def test_a_word_asks_for_each_sensor_it_declares_and_is_never_told_nothing_is_there(word: Any) -> None:
    for sensor in word.needs:
        told = [is_told(word, percepts) for percepts in situations(ALL_SENSORS - {sensor})]
        assert not all(told), f"{word.sense} declares {sensor} and never asks for it"


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
