"""A world as it is drawn: smooth between what robots tell, with where they were of late."""

from typing import cast

import pytest

from web.api_types import Layout, Telemetry
from web.live_world import MAX_TRAIL_POINTS, LiveWorld
from web.world_feed import WorldFeed, WorldSnapshot

LAYOUT = Layout.model_validate(
    {
        "compartments": [{"name": "yard", "x": [0, 80], "y": [0, 3]}],
        "robots": [{"name": "fred", "start": [0, 0, 0]}],
    }
)


class FakeFeed:
    """Hands out what a test tells it."""

    def __init__(self) -> None:
        self.latest = WorldSnapshot()

    def start(self) -> None:
        pass

    def tell(self, time_s: float, x_m: float, heading_rad: float = 0.0) -> None:
        robots = {"fred": {"x_m": x_m, "y_m": 1.0, "heading_rad": heading_rad, "at_s": time_s}}
        telemetry = Telemetry.model_validate({"time_s": time_s, "robots": robots})
        self.latest = WorldSnapshot(layout=LAYOUT, telemetry=telemetry)


class Followed:
    """A world before a fake feed, at a time that the test says."""

    def __init__(self) -> None:
        self.feed, self.now_s = FakeFeed(), 0.0
        self.world = LiveWorld(cast(WorldFeed, self.feed), clock=lambda: self.now_s)

    def x_m(self, now_s: float) -> float:
        self.now_s = now_s
        self.world.update()
        return self.world.frame.robots["fred"].x_m


@pytest.fixture
def followed() -> Followed:
    followed = Followed()
    followed.feed.tell(0.0, 1.0)
    followed.x_m(0.0)
    return followed


def test_a_robot_glides_to_where_it_says_it_is_in_the_time_that_it_took(followed: Followed) -> None:
    followed.feed.tell(0.1, 2.0)
    assert [followed.x_m(now_s) for now_s in (0.1, 0.15, 0.2, 0.25)] == pytest.approx([1.0, 1.5, 2.0, 2.0])


def test_a_world_in_which_nothing_is_new_keeps_its_frame(followed: Followed) -> None:
    followed.feed.tell(0.1, 2.0)
    followed.x_m(0.1)
    followed.x_m(0.3)
    frame = followed.world.frame
    followed.x_m(0.5)
    assert followed.world.frame is frame


def test_a_turn_goes_the_short_way_round(followed: Followed) -> None:
    followed.feed.tell(0.1, 1.0, heading_rad=3.0)
    followed.x_m(0.1)
    followed.x_m(0.3)
    followed.feed.tell(0.4, 1.0, heading_rad=-3.0)
    followed.x_m(0.4)
    followed.x_m(0.45)
    assert 3.0 < followed.world.frame.robots["fred"].heading_rad < 3.3


def test_a_robot_that_was_set_elsewhere_does_not_glide_there(followed: Followed) -> None:
    followed.feed.tell(0.1, 60.0)
    assert followed.x_m(0.1) == 60.0


def test_trails_are_as_long_as_they_may_be_and_begin_again_with_the_world(followed: Followed) -> None:
    for step in range(3 * MAX_TRAIL_POINTS):
        followed.feed.tell(step, step / 4)
        followed.x_m(step)
    trail = followed.world.frame.trails["fred"]
    assert len(trail) == MAX_TRAIL_POINTS
    assert trail[-1] == ((3 * MAX_TRAIL_POINTS - 1) / 4, 1.0)
    followed.feed.tell(0.0, 1.0)
    followed.x_m(1000.0)
    assert followed.world.frame.trails["fred"] == [(1.0, 1.0)]
