"""Activities in a cascade (SRA, implementation): modules that sense, real or virtual, one after the other."""

from collections.abc import Iterable
from typing import Protocol

from robots.physical.body import Readings


class Activity(Protocol):
    """A module of the reactive controller: takes what those before it have sensed, and hands on its own account."""

    def process(self, readings: Readings) -> Readings: ...


def cascade(readings: Readings, activities: Iterable[Activity]) -> Readings:
    """What all activities make of it, in the order of their installation: each is given what the one before gave."""
    for activity in activities:
        readings = activity.process(readings)
    return readings
