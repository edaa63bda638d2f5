"""Sloping ground: how much farther a way over it seems, and what a world file may not say of it."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.world import Slope
from robots.world.parts import Rectangle
from robots.world.slopes import level_way_m, pace_at
from tests.robots.world.test_file import refusal

HALF = Slope(name="hill", x=(2, 4), y=(0, 6), pace=0.5)
COORDINATES = st.tuples(st.floats(-10, 10), st.floats(-10, 10))


def test_the_part_of_a_way_on_a_slope_counts_by_the_time_that_it_takes() -> None:
    assert level_way_m((0, 3), (6, 3), [HALF]) == pytest.approx(4 + 2 / 0.5)
    assert level_way_m((3, 1), (3, 5), [HALF]) == pytest.approx(8)
    assert level_way_m((0, 3), (0, 9), [HALF]) == 6
    assert level_way_m((0, 7), (6, 7), [HALF]) == 6


def test_a_limit_counts_beside_the_slopes_pace_and_the_least_of_several() -> None:
    yard = Rectangle(name="yard", x=(3, 5), y=(0, 6))
    gate = Rectangle(name="gate", x=(4.5, 5), y=(0, 6))
    way_m = level_way_m((0, 3), (6, 3), [HALF], [(yard, 0.5), (gate, 0.25)])
    assert way_m == pytest.approx(2 + 1 / 0.5 + 1 / 0.25 + 0.5 / 0.5 + 0.5 / 0.25 + 1)


def test_a_robot_drives_at_the_slopes_pace_on_it() -> None:
    assert [pace_at(point, [HALF]) for point in ((3, 3), (1, 3), (3, 7))] == [0.5, 1, 1]


@given(start=COORDINATES, middle=COORDINATES, end=COORDINATES)
def test_a_way_is_as_long_back_and_no_longer_than_all_of_it_on_the_slope(
    start: tuple[float, float], middle: tuple[float, float], end: tuple[float, float]
) -> None:
    way_m = level_way_m(start, end, [HALF])
    level_m = level_way_m(start, end, [])
    assert way_m == pytest.approx(level_way_m(end, start, [HALF]))
    assert level_m - 1e-9 <= way_m <= 2 * level_m + 1e-9


@pytest.mark.parametrize(
    ("slopes", "words"),
    [
        ([{"name": "a", "x": [1, 1], "y": [0, 2], "pace": 0.5}], "slopes.0: x: 1 must be greater than 1"),
        ([{"name": "a", "x": [0, 1], "y": [0, 2], "pace": 0}], "slopes.0.pace"),
        (
            [{"name": name, "x": [0, 2], "y": [y, y + 2], "pace": 0.5} for name, y in (("a", 0), ("b", 1))],
            "slopes.b overlaps slopes.a",
        ),
        ([{"name": "left", "x": [0, 1], "y": [0, 2], "pace": 0.5}], "left"),
    ],
)
def test_what_is_no_slope_is_refused(tmp_path: Path, slopes: list[dict[str, object]], words: str) -> None:
    assert words in refusal(tmp_path, slopes=slopes)
