"""The percepts of one tick: readings, pose estimate, and a short memory of sightings."""

from cmath import phase, rect
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite, pi
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from robots.data import NamedVariant
from robots.errors import SensorOff
from robots.perception.health import Defect
from robots.perception.holding_off import hold_off_point
from robots.perception.obstacles import Obstacles
from robots.perception.progress import NO_PROGRESS, Progress
from robots.perception.sensing import MutualDataStore
from robots.perception.tracking import Cursor
from robots.physical.body import GRIPPER_REACH_M, NOTHING_MEASURED, Gripper, Pose, Sensor
from robots.physical.geometry import to_robot, to_world, wrap
from robots.physical.profile import RobotProfile
from robots.physical.sightings import Sightings
from robots.physical.stand_off import STAND_OFF_M


class DriveCommand(NamedTuple):
    """The command of an operator who drives the robot, both in [-1, 1].

    `forward`: share of the speed that a driven robot may have, negative back; `left`: share of the robot's turn rate.
    """

    forward: float = 0.0
    left: float = 0.0

    @property
    def moves(self) -> bool:
        return self != (0.0, 0.0)


class LastSight(NamedTuple):
    """When something went out of view, its range then, and its place in the world's frame, metres."""

    at_s: float
    range_m: float
    at: complex


REMEMBERED_S = 5.0
"""How long a tag that is out of view is assumed to lie where it was."""
FRESH_S = 1.0
"""How long another robot that is out of view is assumed to stand where it was."""
HANDLE_OF = "@"
HOLD_OFF = "@off"
"""After the name of a place: the place as approached by a robot that holds off it."""
STANDS_AT_M = 0.5
"""A robot this near to a handle stands at it."""

T = TypeVar("T")

Needs = frozenset[str]
"""The sensors that a condition or stimulus reads: they must run while it is in use."""
NOTHING: Needs = frozenset()
GRIP: Needs = frozenset({Sensor.GRIPPER})
SIGHT: Needs = frozenset({Sensor.INFRA_RED})
HEAD: Needs = frozenset({Sensor.CAPTURE_HEAD})
TOUCH: Needs = frozenset({Sensor.BUMPER})
LOCATING: Needs = SIGHT | GRIP
SURROUNDINGS: Needs = LOCATING | {Sensor.ULTRASONIC}
TRACKING: Needs = SURROUNDINGS | TOUCH


class SensingVariant(NamedVariant):
    """Base of conditions and stimuli; `class Holding(Condition, needs=GRIP)` declares the sensors that it needs."""

    _needs: ClassVar[Needs]

    def __init_subclass__(cls, needs: Needs = NOTHING) -> None:
        super().__init_subclass__()
        cls._needs = needs

    @classmethod
    def needs_of_all(cls) -> Needs:
        """The sensors that every one of this class needs, whatever its fields."""
        return cls._needs

    @property
    def needs(self) -> Needs:
        """The sensors whose percepts it reads."""
        return self._needs


@dataclass(slots=True, kw_only=True)
class Percepts:
    """All that conditions and stimuli may read. Points are complex, in the robot's frame, metres.

    `data` holds the readings of the running sensors. `seen` (what is in view), `solid` (obstacles seen in infra-red)
    and `about` (all obstacles) are computed from them, None if a sensor they need is off; their properties then raise
    `SensorOff`, for not sensed does not mean "nothing there". `odometry` is the dead-reckoned pose. The packet
    fills in `progress`, the agent `drive_command` (None if no operator drives); nothing else is changed. `degraded`:
    readings that are left out. `measured`: what sensors of installed packages read, by quantity. `last_seen`: the last
    sight of each beacon, robot or tag that was in view before. `last_held`: what the jaws were last sensed to hold,
    for telemetry; conditions and stimuli read `holding`.
    """

    profile: RobotProfile
    time_s: float
    pose: Pose
    odometry: Pose
    data: MutualDataStore = field(default_factory=MutualDataStore)
    seen: Sightings | None = None
    solid: Obstacles | None = None
    about: Obstacles | None = None
    cursors: Mapping[str, Cursor] = field(default_factory=dict)
    bumped_s: float | None = None
    battery: float = 1.0
    charging: bool = False
    measured: Mapping[str, float] = field(default_factory=lambda: NOTHING_MEASURED)
    degraded: tuple[Defect, ...] = ()
    last_seen: Mapping[str, LastSight] = field(default_factory=dict)
    last_held: str | None = None
    progress: Progress = NO_PROGRESS
    drive_command: DriveCommand | None = None
    _found: dict[Hashable, Any] = field(default_factory=dict, init=False, compare=False, repr=False)

    def once(self, asked: Hashable, work: Callable[[], T]) -> T:
        """The result of `work`, computed once a tick although several patterns need it.

        :param asked: the key of the result.
        """
        if asked not in self._found:
            self._found[asked] = work()
        found: T = self._found[asked]
        return found

    @property
    def me(self) -> str:
        return self.profile.name

    @property
    def sightings(self) -> Sightings:
        """The infra-red beacons in view, by identity."""
        return _known(self.seen, SIGHT)

    @property
    def bodies(self) -> Obstacles:
        """Obstacles seen in infra-red: other robots, and samples that are not held."""
        return _known(self.solid, LOCATING)

    @property
    def obstacles(self) -> Obstacles:
        """Everything in the way, by infra-red and whiskers."""
        return _known(self.about, SURROUNDINGS)

    @property
    def ranges_m(self) -> NDArray[np.float64]:
        """Shape (N,), metres, beam 0 straight ahead, counter-clockwise, inf where nothing is in range."""
        ranges: NDArray[np.float64] = self.data.get(Sensor.ULTRASONIC)
        return ranges

    @property
    def bumper(self) -> bool:
        return bool(self.data.get(Sensor.BUMPER))

    @property
    def gripper(self) -> Gripper:
        gripper: Gripper = self.data.get(Sensor.GRIPPER)
        return gripper

    @property
    def capture_head_m(self) -> tuple[float, float]:
        """Deflection (x, y), metres."""
        deflection: tuple[float, float] = self.data.get(Sensor.CAPTURE_HEAD)
        return deflection

    @property
    def holding(self) -> str | None:
        return self.gripper.holding

    @property
    def tags(self) -> tuple[str, ...]:
        """Samples in view, without the one held."""
        places = self.profile.places
        fellows = self.profile.fellows
        mine = (self.me, self.holding)
        seen = self.sightings.names
        return tuple([one for one in seen if one not in places and one not in fellows and one not in mine])

    def sees(self, identity: str) -> bool:
        return identity in self.sightings

    def locate(self, identity: str) -> complex | None:
        """The place of something: in the jaws, as sighted, on the map, a way-point, or remembered; None if unknown.

        Of a long object its centre, or a handle: `beam@left`, `beam@right` as seen from the side from which it is
        gripped, `beam@free`, the first of them at which no other robot stands.
        """
        if identity not in self._found:
            self._found[identity] = self._locate(identity)
        at: complex | None = self._found[identity]
        return at

    def _locate(self, identity: str) -> complex | None:  # noqa: PLR0911
        if identity.endswith(HOLD_OFF):
            return self.locate(identity.removesuffix(HOLD_OFF))
        if HANDLE_OF in identity:
            return self._handle(identity)
        if identity == self.holding and identity not in self.profile.lengths_m:
            return complex(GRIPPER_REACH_M)
        sighting = self.sightings.get(identity)
        if sighting is not None:
            return rect(sighting.range_m, sighting.bearing_rad)
        place = self.profile.places.get(identity)
        if place is not None:
            return to_robot(self.pose, place.point)
        point = _waypoint(identity)
        if point is not None:
            return to_robot(self.pose, point)
        track = self.cursors.get(identity)
        if track is None:
            return None
        remembered_s = FRESH_S if identity in self.profile.fellows else REMEMBERED_S
        return to_robot(self.pose, track.at) if self.time_s - track.seen_s <= remembered_s else None

    def axis(self, place: str) -> float | None:
        """The emitting direction of a place's beacon on the robot's side, radians, robot's frame; None if unknown.

        Of a long object's handle: square to the object, on the side from which it is gripped.
        """
        if HANDLE_OF in place:
            return self._side(place.partition(HANDLE_OF)[0])
        sighting = self.sightings.get(place)
        if sighting is not None:
            return wrap(sighting.bearing_rad + pi - sighting.aspect_rad)
        spec = self.profile.places.get(place)
        beacon = self.locate(place)
        if spec is None or beacon is None:
            return None
        mine = phase(-beacon)
        axes = [wrap(angle - self.pose.heading_rad) for angle in spec.approach_rad]
        return min(axes, key=lambda angle: abs(wrap(angle - mine)))

    def approach_point(self, place: str) -> complex | None:
        """The point `near` a place: on the emitting axis, at the stand-off from the beacon; or where to hold off it."""
        return self.once(("near", place), lambda: self._approach_point(place))

    def _approach_point(self, place: str) -> complex | None:
        if place.endswith(HOLD_OFF):
            return self._hold_off_point(place.removesuffix(HOLD_OFF))
        beacon = self.locate(place)
        axis = self.axis(place)
        return None if beacon is None or axis is None else beacon + rect(STAND_OFF_M, axis)

    def _hold_off_point(self, place: str) -> complex | None:
        robots = (to_world(self.pose, at) for _, at in self.robots_in_view())
        point = hold_off_point(self.profile, place, to_world(self.pose, 0j), robots)
        return None if point is None else to_robot(self.pose, point)

    def _handle(self, identity: str) -> complex | None:
        """A handle of a long object in view."""
        thing, _, which = identity.partition(HANDLE_OF)
        middle = self.locate(thing)
        axis = self.axis(identity)
        length_m = self.profile.lengths_m.get(thing)
        if middle is None or axis is None or length_m is None:
            return None
        left = middle + rect(length_m / 2, axis - pi / 2)
        if which == "free":
            taken = any(abs(at - left) <= STANDS_AT_M for _, at in self.robots_in_view())
            which = "right" if taken else "left"
        return left if which == "left" else 2 * middle - left

    def _side(self, thing: str) -> float | None:
        """The direction from which a long object is gripped: another robot's if one stands at it, else this robot's."""
        middle = self.locate(thing)
        axis = self.axis(thing)
        if middle is None or axis is None:
            return None
        half = rect(self.profile.lengths_m.get(thing, 0.0) / 2, axis + pi / 2)
        for _, at in self.robots_in_view():
            gap = min(at - middle - half, at - middle + half, key=abs)
            if abs(gap) <= STANDS_AT_M and (gap * rect(1.0, -axis)).real < 0:
                return wrap(axis + pi)
        return axis

    def robots_in_view(self) -> Iterator[tuple[str, complex]]:
        """Other robots and their places, seen now or within `FRESH_S`."""
        for name in self.profile.others:
            at = self.locate(name) if name in self.sightings or name in self.cursors else None
            if at is not None:
                yield name, at

    def in_view_for_s(self, identity: str) -> float:
        """How long something has been in view; 0 if it is not."""
        track = self.cursors.get(identity)
        return self.time_s - track.in_view_since_s if track is not None and self.sees(identity) else 0.0

    def still_for_s(self, identity: str) -> float:
        """How long something in view has not moved."""
        track = self.cursors.get(identity)
        return self.time_s - track.still_since_s if track is not None and self.sees(identity) else 0.0

    def evidence(self, identity: str) -> float:
        """The evidence in [0, 1] that something is where its cursor is."""
        cursor = self.cursors.get(identity)
        evidence = 0.0 if cursor is None else cursor.evidence_at(self.time_s)
        return _known(evidence if self.data.holds(TRACKING) else None, TRACKING)


def waypoint(x_m: float, y_m: float) -> str:
    """The name that stands for a point of the world's frame (SRA's [X, Y]).

    :raises ValueError: if it is no point.
    """
    if not (isfinite(x_m) and isfinite(y_m)):
        raise ValueError(f"({x_m}, {y_m}) is not a point")
    return f"({x_m:.3f}, {y_m:.3f})"


@lru_cache(maxsize=1024)
def _waypoint(identity: str) -> complex | None:
    """The point that a name stands for, if it is a way-point's."""
    if not identity.startswith("("):
        return None
    x, _, y = identity.strip("()").partition(", ")
    return complex(float(x), float(y))


def _known(made: T | None, of: Needs) -> T:
    """:raises SensorOff: if a sensor it is made of does not run."""
    if made is None:
        raise SensorOff(f"an action reads percepts of {', '.join(sorted(of))}, not all of which run")
    return made
