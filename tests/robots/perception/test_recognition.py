"""What stands alone among whiskers' hits is a thing; a wall is none; what is believed in gets no second name."""

from cmath import rect
from math import inf, pi, tau

import numpy as np
import pytest

from robots.perception.recognition import HALF_THING_M, alone, by_touch, by_whiskers
from robots.perception.tracking import Cursor, Cursors, Modality, Observation
from robots.physical.body import RADIUS_M, Pose

HERE = Pose(x_m=1, y_m=2, heading_rad=pi / 2)


def cursor(at: complex) -> Cursor:
    return Cursor(at=at, seen_s=0, in_view_since_s=0, anchor=at, still_since_s=0)


def at(beam: int, range_m: float) -> complex:
    """The middle of a thing whose surface a beam meets."""
    return rect(RADIUS_M + range_m + HALF_THING_M, tau * beam / 16)


def places(told: Observation) -> dict[str, complex]:
    return dict(zip(told.names, told.at.tolist(), strict=True))


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
    met = alone(np.array(whiskers(hits)), RADIUS_M)
    assert met == pytest.approx([np.mean([at(beam, hits[beam]) for beam in group]) for group in groups])


def test_a_nameless_thing_gets_a_name_and_keeps_it() -> None:
    ranges = np.array(whiskers({0: 0.5, 8: 0.5}))
    first = places(by_whiskers(ranges, HERE, Cursors.of({})))
    assert set(first) == {"thing_1", "thing_2"}
    assert first["thing_1"] == pytest.approx(1 + 2.82j)
    again = by_whiskers(ranges, HERE, Cursors.of({name: cursor(at) for name, at in first.items()}))
    assert places(again) == first


def test_whiskers_and_bumper_tell_of_a_thing_known_by_name() -> None:
    known = Cursors.of({"ball": cursor(1 + 2.9j)})
    met = by_whiskers(np.array(whiskers({0: 0.5})), HERE, known)
    felt = by_touch(1 + 2.75j, known)
    assert (met.names, met.modality) == (("ball",), Modality.ULTRASONIC)
    assert (felt.names, felt.modality) == (("ball",), Modality.TOUCH)
    assert by_touch(5 + 5j, known).names == ("thing_1",)
