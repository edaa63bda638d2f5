"""Turns a body's raw readings into percepts, tick by tick, and finds out when a sensor lies."""

from cmath import rect
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import isfinite, pi

import numpy as np

from robots.body import RADIUS_M, Gripper, Pose, Sensor, Sighting
from robots.datastore import MutualDataStore
from robots.errors import SensorFault
from robots.geometry import to_robot
from robots.localisation import Localiser
from robots.percepts import (
    LOCATING,
    REMEMBERED_S,
    SAMPLE_RADIUS_M,
    SURROUNDINGS,
    WHISKER_RADIUS_M,
    Obstacle,
    Percepts,
)
from robots.profile import RobotProfile
from robots.tracking import ObjectTracking
from robots.tracking.recognition import by_infra_red, by_touch, by_whiskers

GONE_S = 0.5
"""What is felt again within this time is still the same."""
LONG_SHARES = (-0.5, -0.25, 0.0, 0.25, 0.5)
"""Where along a long object it is taken to be in the way."""
BUMP_RADIUS_M = 0.08
"""What was bumped into is taken to be of this size and ahead: the bumper tells no direction, and a robot drives ahead
(our choice).
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bump:
    """Something felt by the bumper: world frame, the robot's clock. `heading_rad` is how the robot ran into it."""

    at: complex
    felt_s: float
    heading_rad: float


class Perception:
    """The robot's fused senses: localisation, recent memory, obstacles."""

    def __init__(self, profile: RobotProfile) -> None:
        self._profile = profile
        self.localiser = Localiser(profile.start, profile.beacons)
        self._tracking = ObjectTracking()
        self._bump: Bump | None = None
        self._last_seen: dict[str, tuple[float, float]] = {}

    def perceive(
        self,
        data: MutualDataStore,
        odometry: Pose,
        now_s: float,
        *,
        battery: float = 1.0,
        charging: bool = False,
        degraded: tuple[str, ...] = (),
    ) -> Percepts:
        """Fuse one instant, of the sensors that run.

        :raises SensorFault: if a reading cannot be; names the sensor.
        """
        check(data, odometry, battery)
        sightings: tuple[Sighting, ...] | None = data.values.get(Sensor.INFRA_RED)
        pose = self.localiser.update(odometry, sightings or ())
        self._last_seen.update((one.identity, (now_s, one.range_m)) for one in sightings or ())
        if data.values.get(Sensor.BUMPER):
            self._bump = self._felt(pose, now_s)
        self._track(data, pose, now_s)
        solid = self._bodies(sightings, data.get(Sensor.GRIPPER)) if data.holds(LOCATING) else None
        around = None if solid is None or not data.holds(SURROUNDINGS) else self._around(data, solid)
        return Percepts(
            profile=self._profile,
            time_s=now_s,
            pose=pose,
            odometry=odometry,
            data=data,
            seen=None if sightings is None else {sighting.identity: sighting for sighting in sightings},
            solid=solid,
            about=None if around is None else (*around, *self._bumped(pose, now_s)),
            cursors=dict(self._tracking.cursors),
            bumped_s=self._bump.felt_s if self._bump else None,
            battery=battery,
            charging=charging,
            degraded=degraded,
            last_seen=self._last_seen,
        )

    def _track(self, data: MutualDataStore, pose: Pose, now_s: float) -> None:
        """Feed object tracking with what the sensors that run tell of things; of places it has the map."""
        places = self._profile.places
        seen = [one for one in data.values.get(Sensor.INFRA_RED, ()) if one.identity not in places]
        self._tracking.observe(by_infra_red(seen, pose), now_s)
        ranges_m = data.values.get(Sensor.ULTRASONIC)
        if ranges_m is not None:
            self._tracking.observe(by_whiskers(ranges_m, pose, self._tracking.cursors), now_s)
        if self._bump is not None and self._bump.felt_s == now_s:
            self._tracking.observe([by_touch(self._bump.at, self._tracking.cursors)], now_s)

    def _bodies(self, sightings: Iterable[Sighting] | None, gripper: Gripper) -> tuple[Obstacle, ...]:
        """Discs around every other robot, and every sample that lies about."""
        found = []
        for sighting in sightings or ():
            at = rect(sighting.range_m, sighting.bearing_rad)
            if sighting.identity in self._profile.fellows:
                found.append(Obstacle(at=at, radius_m=RADIUS_M, is_robot=True))
            elif self._profile.is_tag(sighting.identity) and sighting.identity != gripper.holding:
                found.extend(self._lying(sighting, at))
        return tuple(found)

    def _lying(self, sighting: Sighting, at: complex) -> Iterator[Obstacle]:
        """A disc around a compact sample; several along a long one."""
        along = rect(
            self._profile.lengths_m.get(sighting.identity, 0.0), sighting.bearing_rad - sighting.aspect_rad
        )
        for share in LONG_SHARES if along else (0.0,):
            yield Obstacle(at=at + share * 1j * along, radius_m=SAMPLE_RADIUS_M)

    def _around(self, data: MutualDataStore, solid: tuple[Obstacle, ...]) -> list[Obstacle]:
        """The bodies, and a disc around every whisker's hit (from the hull) that is not a body's.

        The least that a whisker can read only says that something is nearer: it is taken to be half as far (our
        choice).
        """
        found = list(solid)
        least_m = self._profile.whisker_least_m
        ranges_m = [r if r > least_m else least_m / 2 for r in data.get(Sensor.ULTRASONIC).tolist()]
        count, robots = len(ranges_m), [one.at for one in solid if one.is_robot]
        for beam, range_m in enumerate(ranges_m):
            if isfinite(range_m):
                hit = rect(RADIUS_M + range_m, 2 * pi * beam / count)
                if not any(abs(at - hit) < RADIUS_M + 0.1 for at in robots):
                    found.append(Obstacle(at=hit, radius_m=WHISKER_RADIUS_M))
        return found

    def _felt(self, pose: Pose, now_s: float) -> Bump:
        """Where the robot ran into something; it does not turn with the robot while they touch."""
        last = self._bump
        still = last is not None and now_s - last.felt_s < GONE_S
        heading_rad = last.heading_rad if last is not None and still else pose.heading_rad
        at = complex(pose.x_m, pose.y_m) + rect(RADIUS_M + BUMP_RADIUS_M, heading_rad)
        return Bump(at=at, felt_s=now_s, heading_rad=heading_rad)

    def _bumped(self, pose: Pose, now_s: float) -> tuple[Obstacle, ...]:
        """What the robot bumped into a while ago, which no other sensor may tell."""
        if self._bump is None or now_s - self._bump.felt_s > REMEMBERED_S:
            return ()
        return (Obstacle(at=to_robot(pose, self._bump.at), radius_m=BUMP_RADIUS_M),)


def check(data: MutualDataStore, odometry: Pose, battery: float) -> None:
    """Refuse readings that cannot be.

    :raises SensorFault: naming the sensor and what it read.
    """
    ranges_m = np.asarray(data.values.get(Sensor.ULTRASONIC, ()))
    for beam in np.flatnonzero(~(ranges_m >= 0)):
        raise SensorFault(f"whisker {beam} reads {ranges_m[beam]}")
    for sighting in data.values.get(Sensor.INFRA_RED, ()):
        numbers = (sighting.range_m, sighting.bearing_rad, sighting.aspect_rad)
        if not isfinite(sum(numbers)):
            raise SensorFault(f"the beacon sensor reads {numbers} for {sighting.identity}")
    if not all(map(isfinite, (odometry.x_m, odometry.y_m, odometry.heading_rad))):
        raise SensorFault(f"odometry reads {odometry}")
    head_m = data.values.get(Sensor.CAPTURE_HEAD, (0.0, 0.0))
    if not all(map(isfinite, head_m)):
        raise SensorFault(f"the capture head reads {head_m}")
    if not 0 <= battery <= 1:
        raise SensorFault(f"the battery reads {battery}")
