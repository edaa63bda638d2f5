"""The avoidance benchmark itself: rooms that can be crossed, and a row a method."""

import pytest

from benchmarks.avoidance import GOAL, METHODS, PASSAGE_M, SIZE_M, START, clutter, drive, gap_m


@pytest.mark.parametrize("seed", range(20))
def test_every_room_leaves_passages_wide_enough(seed: int) -> None:
    boxes = clutter(seed, 8)
    assert len(boxes) >= 4
    for number, box in enumerate(boxes):
        assert all(gap_m(box, other) >= PASSAGE_M for other in boxes[:number])
        assert all(gap_m(box, (*point, *point)) > PASSAGE_M for point in (START[:2], GOAL))
        assert 0 <= box[1] < box[3] <= SIZE_M[1]


def test_the_same_seed_is_the_same_room() -> None:
    assert clutter(3, 8) == clutter(3, 8) != clutter(4, 8)


@pytest.mark.parametrize("method", METHODS)
def test_a_drive_tells_whether_it_arrived_and_how(method: str) -> None:
    one = drive(method, 0, 2)
    assert (one.arrived, one.touched) == (True, False)
    assert one.way_m > GOAL[0] - START[0] - 0.6
