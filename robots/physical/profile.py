"""A robot's configuration: its own properties and its map of places."""

from cmath import rect
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi

from robots.data import StrEnum
from robots.physical.body import ALL_SENSORS, RADIUS_M, Pose
from robots.physical.stand_off import STAND_OFF_M

Area = tuple[float, float, float, float]
"""A rectangle of the floor: least x, greatest x, least y, greatest y, metres, world frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BeaconSpec:
    """A fixed beacon on the robot's map: world frame, metres; directions in which it emits, radians."""

    x_m: float
    y_m: float
    approach_rad: tuple[float, ...]

    @property
    def point(self) -> complex:
        return complex(self.x_m, self.y_m)

    @property
    def approach_points(self) -> tuple[complex, ...]:
        """Where a robot stands `near` it: one for each direction."""
        return tuple(self.point + rect(STAND_OFF_M, angle) for angle in self.approach_rad)


class Architecture(StrEnum):
    """How sensing and acting are scheduled."""

    PARALLEL = "parallel"
    """Sensing beside acting (P-SMPA)."""
    SEQUENTIAL = "sequential"
    """Sensing and acting in turn (SMPA), for comparison."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotProfile:
    """A robot's configuration. `sensors`: those that its body has, and its cameras; `whisker_least_m`: the shortest
    range that its whiskers read.

    `beacons` must name every fixed beacon in sight: a sighting that is neither a beacon nor one of `others` counts as
    the tag of a sample. `lengths_m`: of the objects that take two robots. `home`: the beacon of its charger, None
    without one. `battery_wh`: what its battery holds when full. `round_trip_s`: the longest round trip of its radio.
    `samples`: those that it was told of; it reports others that it sees. None: it is not told of samples, and reports
    none.
    """

    name: str
    start: Pose
    beacons: Mapping[str, BeaconSpec]
    speed_m_s: float = 0.5
    turn_rad_s: float = 1.5
    repertoire: tuple[str, ...] = ("NAVIGATE", "DOCK", "DOCK2", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK")
    others: tuple[str, ...] = ()
    home: str | None = None
    battery_wh: float = 120.0
    architecture: Architecture = Architecture.PARALLEL
    sensors: frozenset[str] = ALL_SENSORS
    whisker_least_m: float = 0.0
    lengths_m: Mapping[str, float] = field(default_factory=dict)
    round_trip_s: float = 0.0
    samples: frozenset[str] | None = None
    keep_out: tuple[Area, ...] = ()
    """Areas that it does not enter."""
    one_robot: tuple[Area, ...] = ()
    """Areas that it does not enter while it sees another robot in them."""
    slow: tuple[tuple[Area, float], ...] = ()
    """Areas with the speed that it keeps to in them, m/s."""
    places: Mapping[str, BeaconSpec] = field(init=False)
    fellows: frozenset[str] = field(init=False)
    """`others` as a set."""

    def __post_init__(self) -> None:
        """Adds the robot's own spot: the place of its start, for which no beacon stands (our choice).

        As for any place, its approach point is the stand-off before it: so `near` the spot is the start pose.
        """
        ahead = complex(self.start.x_m, self.start.y_m) + rect(STAND_OFF_M, self.start.heading_rad)
        spot = BeaconSpec(x_m=ahead.real, y_m=ahead.imag, approach_rad=(self.start.heading_rad + pi,))
        object.__setattr__(self, "fellows", frozenset(self.others))
        object.__setattr__(self, "places", {f"{self.name}_spot": spot, **self.beacons})

    def speed_at(self, pose: Pose) -> float:
        """Its full speed there, m/s: in a slow area, as soon as its hull is, no more than the area's."""
        limits = (
            limit_m_s
            for (left, right, low, high), limit_m_s in self.slow
            if left - RADIUS_M <= pose.x_m <= right + RADIUS_M
            and low - RADIUS_M <= pose.y_m <= high + RADIUS_M
        )
        return min((self.speed_m_s, *limits))
