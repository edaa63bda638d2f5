"""Wall-clock times map to times of a world's clock."""

from datetime import UTC, datetime

import pytest

from app.recordings.clock_map import ClockMap
from robots.clock import ManualClock
from tests.app.stepped_clock import SteppedClock

NOON_S = datetime(2026, 11, 21, 12, tzinfo=UTC).timestamp()


def written(after_s: float) -> str:
    return datetime.fromtimestamp(NOON_S + after_s, UTC).isoformat()


def test_a_wall_clock_time_maps_to_what_the_worlds_clock_showed_then() -> None:
    wall = SteppedClock(NOON_S)
    world = ManualClock(100.0)
    clock_map = ClockMap({"store": world}, wall=wall)
    for step_s in (6.0, 0.0, 6.0):  # six times as fast as the wall clock, and at a stand in between
        clock_map.read()
        world.advance(step_s)
        wall.advance(1.0)
    dated = {after_s: clock_map.at_s("store", written(after_s)) for after_s in (-60, 0, 0.5, 1.5, 2.5, 9)}
    assert dated == pytest.approx({-60: 100, 0: 100, 0.5: 103, 1.5: 106, 2.5: 109, 9: 112})
