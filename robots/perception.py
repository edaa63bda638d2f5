"""Turns a body's raw readings into percepts, tick by tick, and finds out when a sensor lies."""

from cmath import rect
from math import isfinite, pi

from robots.body import RADIUS_M, Pose, Readings, Sighting
from robots.errors import SensorFault
from robots.geometry import to_world
from robots.localisation import Localiser
from robots.percepts import SAMPLE_RADIUS_M, WHISKER_RADIUS_M, Obstacle, Percepts, Track
from robots.profile import RobotProfile

STILL_M = 0.1
"""A tag that seems to move by less than this has not moved: it is within the sensor's noise."""
GONE_S = 0.5
"""Out of view for longer than this breaks a view."""


class Perception:
    """The robot's fused senses: localisation, recent memory, obstacles."""

    def __init__(self, profile: RobotProfile) -> None:
        self._profile = profile
        self._localiser = Localiser(profile.start, profile.beacons)
        self._tracks: dict[str, Track] = {}

    def perceive(self, readings: Readings, odometry: Pose, now_s: float) -> Percepts:
        """Fuse one instant.

        :raises SensorFault: if a reading cannot be; names the sensor.
        """
        check(readings, odometry)
        pose = self._localiser.update(odometry, readings.sightings)
        for sighting in readings.sightings:
            if sighting.identity not in self._profile.places:
                self._remember(sighting, pose, now_s)
        return Percepts(
            profile=self._profile,
            time_s=now_s,
            pose=pose,
            readings=readings,
            sightings={sighting.identity: sighting for sighting in readings.sightings},
            tracks=dict(self._tracks),
            obstacles=self._obstacles(readings),
            odometry=odometry,
        )

    def _remember(self, sighting: Sighting, pose: Pose, now_s: float) -> None:
        at = to_world(pose, rect(sighting.range_m, sighting.bearing_rad))
        old = self._tracks.get(sighting.identity)
        new_view = old is None or now_s - old.seen_s > GONE_S
        moved = old is None or abs(at - old.anchor) > STILL_M
        self._tracks[sighting.identity] = Track(
            at=at,
            seen_s=now_s,
            in_view_since_s=now_s if old is None or new_view else old.in_view_since_s,
            anchor=at if old is None or moved else old.anchor,
            still_since_s=now_s if old is None or moved or new_view else old.still_since_s,
        )

    def _obstacles(self, readings: Readings) -> tuple[Obstacle, ...]:
        """Discs around every whisker's hit (from the hull), other robot, and sample that lies about."""
        found = []
        for sighting in readings.sightings:
            at = rect(sighting.range_m, sighting.bearing_rad)
            if sighting.identity in self._profile.others:
                found.append(Obstacle(at=at, radius_m=RADIUS_M, is_robot=True))
            elif self._profile.is_tag(sighting.identity) and sighting.identity != readings.gripper.holding:
                found.append(Obstacle(at=at, radius_m=SAMPLE_RADIUS_M))
        count = len(readings.ranges_m)
        for beam, range_m in enumerate(readings.ranges_m):
            if isfinite(range_m):
                hit = rect(RADIUS_M + float(range_m), 2 * pi * beam / count)
                if not any(one.is_robot and abs(one.at - hit) < RADIUS_M + 0.1 for one in found):
                    found.append(Obstacle(at=hit, radius_m=WHISKER_RADIUS_M))
        return tuple(found)


def check(readings: Readings, odometry: Pose) -> None:
    """Refuse readings that cannot be.

    :raises SensorFault: naming the sensor and what it read.
    """
    for beam, range_m in enumerate(readings.ranges_m):
        if not range_m >= 0:
            raise SensorFault(f"whisker {beam} reads {range_m}")
    for sighting in readings.sightings:
        numbers = (sighting.range_m, sighting.bearing_rad, sighting.aspect_rad)
        if not all(map(isfinite, numbers)):
            raise SensorFault(f"the beacon sensor reads {numbers} for {sighting.identity}")
    if not all(map(isfinite, (odometry.x_m, odometry.y_m, odometry.heading_rad))):
        raise SensorFault(f"odometry reads {odometry}")
    if not all(map(isfinite, readings.capture_head_m)):
        raise SensorFault(f"the capture head reads {readings.capture_head_m}")
    if not 0 <= readings.battery <= 1:
        raise SensorFault(f"the battery reads {readings.battery}")
