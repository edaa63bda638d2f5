"""Readings that cannot be are refused by name; the rest is fused."""

from math import pi

import pytest

from robots.physical.body import RADIUS_M
from tests.robots.sensed import percepts, readings, sees, watch


def test_the_approach_point_is_the_stand_off_before_the_beacon() -> None:
    seen = percepts(sees("bay", 2, 0, 0))
    assert seen.approach_point("bay") == pytest.approx(1.2)


def test_aspect_turns_the_approach_point_about_the_beacon() -> None:
    """The observer stands a quarter turn counter-clockwise of the axis: the point lies to its left."""
    point = percepts(sees("bay", 2, 0, pi / 2)).approach_point("bay")
    assert point == pytest.approx(2 + 0.8j)


def test_a_beacon_out_of_sight_is_where_the_map_says() -> None:
    assert percepts().locate("bay") == pytest.approx(2)
    assert percepts().approach_point("bay") == pytest.approx(1.2)


def test_a_tag_out_of_sight_is_remembered_for_a_while() -> None:
    seen = [readings(sees("sample", 1, 0.5))]
    assert abs(watch(seen + [readings()] * 40).locate("sample") or 0) == pytest.approx(1)
    assert watch(seen + [readings()] * 140).locate("sample") is None


def test_another_robot_is_one_obstacle_though_whiskers_meet_it_too() -> None:
    seen = percepts(sees("other", 1), whiskers={0: 1 - 2 * RADIUS_M})
    assert [one.is_robot for one in seen.obstacles] == [True]


def test_the_held_sample_is_no_obstacle() -> None:
    assert not percepts(sees("sample", 0.34), closed=True, between="sample").obstacles
