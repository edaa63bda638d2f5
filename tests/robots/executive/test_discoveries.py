"""A robot reports a sample that it was not told of once it sees it lie still in a place."""

from dataclasses import replace

from robots.executive.discoveries import Discoveries
from robots.perception.percepts import Percepts
from tests.robots.sensed import PROFILE, percepts, sees

AT_BAY = percepts(sees("bay", 2), sees("sample", 2))
"""The bay is 2 m ahead."""


def reported(known: set[str] | None, *seen: Percepts) -> list[tuple[str, str]]:
    discoveries = Discoveries(replace(PROFILE, samples=None if known is None else frozenset(known)))
    return [(one.sample, one.place) for sensed in seen for one in discoveries.new(sensed)]


def test_an_unknown_sample_is_reported_once_with_its_place() -> None:
    assert reported({"beam"}, AT_BAY, AT_BAY) == [("sample", "bay")]


def test_known_samples_are_not_reported_nor_any_by_a_robot_that_was_told_of_none() -> None:
    assert reported({"sample"}, AT_BAY) == reported(None, AT_BAY) == []


def test_a_sample_that_moves_lies_nowhere_or_is_with_a_robot_is_not_reported() -> None:
    just_seen = percepts(sees("bay", 2), sees("sample", 2), for_s=0.1)
    on_the_floor = percepts(sees("bay", 2), sees("sample", 1))
    carried = percepts(sees("bay", 2), sees("sample", 2), sees("other", 1.7))
    assert reported(set(), just_seen, on_the_floor, carried) == []
