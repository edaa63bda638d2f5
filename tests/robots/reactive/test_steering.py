"""Stimuli of the behavioural suite that are read from where things are."""

from cmath import pi, rect
from typing import cast

import pytest

from robots.perception.percepts import Percepts
from robots.reactive.steering import Distance


class Seen:
    """Percepts of a robot that knows where one thing is, as a point in its frame, metres."""

    def __init__(self, at: complex | None) -> None:
        self._at = at

    def locate(self, target: str) -> complex | None:
        return self._at


def distance(at: complex | None, keep_m: float = 0.5) -> float | None:
    return Distance(target="sample", keep_m=keep_m, full_m=1.0).read(cast(Percepts, Seen(at)))


@pytest.mark.parametrize(
    ("at", "strength"),
    [
        (rect(0.5, 0.0), 0.0),
        (rect(1.1, 0.0), 0.6),
        (rect(3.0, 0.0), 1.0),
        (rect(0.1, 0.0), -0.4),
        (rect(3.0, pi / 3), 0.25),
        (rect(3.0, -pi / 3), 0.25),
        (rect(3.0, 0.6 * pi), 0.0),
    ],
)
def test_a_distance_is_strongest_straight_ahead_and_nothing_off_to_the_side(
    at: complex, strength: float
) -> None:
    assert distance(at) == pytest.approx(strength)


def test_without_a_distance_to_keep_or_a_thing_to_keep_it_from_there_is_none() -> None:
    assert distance(rect(1.0, 0.0), keep_m=0.0) is None
    assert distance(None) is None
