"""The world as it is: for the control channel and tests only, never for an agent."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from robots.body import Pose


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTruth:
    """Where a sample is: metres in the world's frame; `heading_rad` is the direction that a long one lies in.

    `place` is the location it lies in, None if in none; `holders` the robots that have it in their jaws.
    """

    x_m: float
    y_m: float
    place: str | None
    holders: tuple[str, ...] = ()
    heading_rad: float = 0.0

    @property
    def ref(self) -> str | None:
        """What the sample is in: a robot's gripper, else a location, else nothing."""
        return self.holders[0] if self.holders else self.place


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """All poses at one instant of the world's clock, and how far objects are off the middles of the capture heads.

    `slipped`: how often, so far, a long object's handle has slipped out of a capture head.
    """

    time_s: float
    robots: Mapping[str, Pose]
    samples: Mapping[str, SampleTruth]
    deflections_m: Mapping[str, float] = field(default_factory=dict)
    slipped: int = 0
