"""The true state of a world: for the control channel and tests only, never for an agent."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import hypot

from robots.physical.body import Pose
from robots.world import WorldFile

LIES_IN_M = 0.25
"""Distance from a location within which a sample lies in it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTruth:
    """A sample's position, metres in the world's frame; `heading_rad` is the direction of a long one.

    `place` is the location it lies in, None if in none; `holders` the robots that hold it.
    """

    x_m: float
    y_m: float
    place: str | None
    holders: tuple[str, ...] = ()
    heading_rad: float = 0.0

    @property
    def ref(self) -> str | None:
        """The robot whose gripper holds the sample, else its location, else None."""
        return self.holders[0] if self.holders else self.place


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """All poses at one instant of the world's clock, and the objects' offsets from the middles of the capture heads.

    `batteries`: by robot, the share of its charge that is left. `slipped`: how often a long object's handle has slipped
    out of a capture head so far.
    """

    time_s: float
    robots: Mapping[str, Pose]
    samples: Mapping[str, SampleTruth]
    deflections_m: Mapping[str, float] = field(default_factory=dict)
    slipped: int = 0
    batteries: Mapping[str, float] = field(default_factory=dict)


def place_at(world: WorldFile, point: tuple[float, float]) -> str | None:
    """The location that something at a point lies in, None if in none."""
    near = [
        (hypot(point[0] - place.at[0], point[1] - place.at[1]), place.name)
        for place in world.places
        if place.capacity
    ]
    distance_m, name = min(near, default=(float("inf"), ""))
    return name if distance_m <= LIES_IN_M else None
