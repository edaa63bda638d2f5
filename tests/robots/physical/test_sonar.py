from cmath import rect
from dataclasses import dataclass, replace
from math import inf, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.physical.body import RADIUS_M, Readings
from robots.physical.sonar import MapSonar, VirtualSonar, Walls, cascade

BEAMS = 16
SILENCE = Readings(time_s=0.0, ranges_m=np.full(BEAMS, inf), bumper=None, sightings=None, gripper=None)


class Around:
    """A workbench that knows simulated robots at these places."""

    def __init__(self, *places: complex) -> None:
        self._places = places

    def simulated_robots(self) -> tuple[complex, ...]:
        return self._places


@dataclass
class Timed:
    """An activity that adds to the time which the one before handed on."""

    by_s: float

    def process(self, readings: Readings) -> Readings:
        return replace(readings, time_s=10 * readings.time_s + self.by_s)


def heard(*places: complex, range_m: float = 2.5, least_m: float = 0.0) -> list[float]:
    sonar = VirtualSonar(Around(*places), beams=BEAMS, range_m=range_m, least_m=least_m)
    ranges_m = sonar.process(SILENCE).ranges_m
    assert ranges_m is not None
    return [float(range_m) for range_m in ranges_m]


def test_each_activity_is_given_what_the_one_before_gave() -> None:
    assert cascade(SILENCE, [Timed(1), Timed(2), Timed(3)]).time_s == 123
    assert cascade(SILENCE, []) is SILENCE


@pytest.mark.parametrize("beam", range(BEAMS))
def test_a_simulated_robot_is_heard_from_hull_to_hull_in_the_beam_that_meets_it(beam: int) -> None:
    ranges_m = heard(rect(1.5, beam * 2 * pi / BEAMS))
    assert ranges_m[beam] == pytest.approx(1.5 - 2 * RADIUS_M)
    assert [range_m < inf for range_m in ranges_m] == [one == beam for one in range(BEAMS)]


@pytest.mark.parametrize(
    ("away_m", "is_heard"), [(2.5 + 2 * RADIUS_M - 0.01, True), (2.5 + 2 * RADIUS_M + 0.01, False)]
)
def test_what_is_out_of_range_is_not_heard(away_m: float, is_heard: bool) -> None:
    assert (heard(complex(away_m, 0))[0] < inf) is is_heard


def test_the_nearest_of_several_is_heard() -> None:
    assert heard(2.0 + 0j, 1.0 + 0j, 1.5 + 0j)[0] == pytest.approx(1.0 - 2 * RADIUS_M)


def test_what_is_nearer_than_the_least_reads_as_that_and_an_overlap_as_touching() -> None:
    assert heard(0.5 + 0j, least_m=0.25)[0] == 0.25
    assert heard(0.1 + 0j) == [0.0] * BEAMS


def test_of_real_and_virtual_sonar_the_nearer_wins_in_every_beam() -> None:
    real_m = np.full(BEAMS, inf)
    real_m[[0, 4, 8]] = 0.3, 2.0, 1.0
    virtual = VirtualSonar(Around(1.5 + 0j, rect(1.5, radians(90))), beams=BEAMS, range_m=2.5)
    ranges_m = cascade(replace(SILENCE, ranges_m=real_m), [virtual]).ranges_m
    assert ranges_m is not None
    assert [ranges_m[beam] for beam in (0, 4, 8)] == pytest.approx([0.3, 1.5 - 2 * RADIUS_M, 1.0])
    assert np.isinf(np.delete(ranges_m, [0, 4, 8])).all()


def test_sonar_that_is_off_hears_nothing_virtually_either() -> None:
    off = replace(SILENCE, ranges_m=None)
    assert VirtualSonar(Around(1.0 + 0j), beams=BEAMS, range_m=2.5).process(off) is off


@given(
    st.lists(st.complex_numbers(max_magnitude=4), max_size=4),
    st.floats(min_value=0, max_value=0.5),
)
def test_a_range_is_never_below_the_least_nor_beyond_the_range(places: list[complex], least_m: float) -> None:
    for range_m in heard(*places, least_m=least_m):
        assert least_m <= range_m <= 2.5 or range_m == inf


class Room:
    """Walls in the robot's own frame, each from end to end."""

    def __init__(self, *walls: tuple[complex, complex]) -> None:
        self._walls = np.array(walls, dtype=np.complex128).reshape(-1, 2)

    def walls(self) -> Walls:
        return self._walls


def echoes(*walls: tuple[complex, complex], least_m: float = 0.0, before: Readings = SILENCE) -> list[float]:
    sonar = MapSonar(Room(*walls), beams=BEAMS, range_m=2.5, least_m=least_m, thickness_m=0.08)
    ranges_m = sonar.process(before).ranges_m
    assert ranges_m is not None
    return [float(range_m) for range_m in ranges_m]


AHEAD = (1 - 0.2j, 1 + 0.2j)


def test_a_wall_of_the_map_gives_its_faces_echo_to_the_beams_that_meet_it() -> None:
    straight = echoes(AHEAD)
    assert straight[0] == pytest.approx(1 - 0.04 - RADIUS_M)
    assert straight[1:] == [inf] * (BEAMS - 1)
    slanted = echoes((1 - 1j, 1 + 1j))
    assert slanted[1] == pytest.approx((1 - 0.04) / np.cos(2 * pi / BEAMS) - RADIUS_M)
    assert echoes() == [inf] * BEAMS


def test_the_nearer_wall_counts_and_what_was_heard_before_it() -> None:
    assert echoes(AHEAD, (0.6 - 1j, 0.6 + 1j))[0] == pytest.approx(0.6 - 0.04 - RADIUS_M)
    assert echoes((3 - 1j, 3 + 1j))[0] == inf, "out of range"
    assert echoes((0.3 - 1j, 0.3 + 1j), least_m=0.25)[0] == 0.25
    before = replace(SILENCE, ranges_m=np.full(BEAMS, 0.1))
    assert echoes(AHEAD, before=before)[0] == 0.1
    off = replace(SILENCE, ranges_m=None)
    assert MapSonar(Room(AHEAD), beams=BEAMS, range_m=2.5, thickness_m=0.08).process(off) is off
