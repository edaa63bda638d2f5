"""What stands alone among whiskers' hits is a thing; a wall is none; what is believed in gets no second name."""

from math import inf, pi

import numpy as np
import pytest

from robots.body import Pose
from robots.tracking import Cursor, Modality
from robots.tracking.recognition import alone, by_touch, by_whiskers

HERE = Pose(x_m=1, y_m=2, heading_rad=pi / 2)


def cursor(at: complex) -> Cursor:
    return Cursor(at=at, seen_s=0, in_view_since_s=0, anchor=at, still_since_s=0)


def whiskers(hits: dict[int, float]) -> list[float]:
    return [hits.get(beam, inf) for beam in range(16)]


@pytest.mark.parametrize(
    ("hits", "groups"),
    [
        ({3: 0.8}, [[3]]),
        ({0: 0.8}, [[0]]),
        ({15: 0.5, 0: 0.5}, [[15, 0]]),
        ({3: 0.8, 9: 0.4}, [[3], [9]]),
        ({3: 0.8, 2: 1.0, 4: 1.1}, []),  # a wall abeam
        ({3: 2.0}, []),  # too far to tell
        (dict.fromkeys(range(16), 0.5), []),  # walled in
        ({}, []),
        (dict.fromkeys(range(16), 2.0) | {5: 0.4}, [[5]]),  # before a wall
    ],
)
def test_narrow_things_with_free_space_beside_stand_alone(
    hits: dict[int, float], groups: list[list[int]]
) -> None:
    assert alone(np.array(whiskers(hits))) == groups


def test_a_nameless_thing_gets_a_name_and_keeps_it() -> None:
    ranges = np.array(whiskers({0: 0.5, 8: 0.5}))
    first = {one.name: one.at for one in by_whiskers(ranges, HERE, {})}
    assert set(first) == {"thing_1", "thing_2"}
    assert first["thing_1"] == pytest.approx(1 + 2.82j)
    again = by_whiskers(ranges, HERE, {name: cursor(at) for name, at in first.items()})
    assert {one.name: one.at for one in again} == first


def test_whiskers_and_bumper_tell_of_a_thing_known_by_name() -> None:
    known = {"ball": cursor(1 + 2.9j)}
    (met,) = by_whiskers(np.array(whiskers({0: 0.5})), HERE, known)
    felt = by_touch(1 + 2.75j, known)
    assert (met.name, met.modality) == ("ball", Modality.ULTRASONIC)
    assert (felt.name, felt.modality) == ("ball", Modality.TOUCH)
    assert by_touch(5 + 5j, known).name == "thing_1"
