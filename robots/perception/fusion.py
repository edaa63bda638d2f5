"""Fuses a body's readings into percepts, tick by tick."""

from cmath import rect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from robots.perception.health import Defect
from robots.perception.localisation import Localiser
from robots.perception.obstacles import NO_OBSTACLE, ROBOT, ObstacleCollector, Obstacles
from robots.perception.percepts import LOCATING, REMEMBERED_S, LastSight, Percepts
from robots.perception.recognition import by_infra_red, by_touch, by_whiskers
from robots.perception.sensing import MutualDataStore
from robots.perception.tracking import ObjectTracking, Observation
from robots.perception.zones import BORDER_RADIUS_M, Borders
from robots.physical.body import NOTHING_MEASURED, RADIUS_M, Pose, Sensor
from robots.physical.geometry import to_robot, to_world
from robots.physical.profile import RobotProfile
from robots.physical.sightings import NONE_IN_VIEW, Sighting, Sightings

CONTACT_GAP_S = 0.5
"""A touch within this time after the last one is the same contact."""
BUMP_RADIUS_M = 0.08
"""The assumed size of what the bumper touches, straight ahead: the bumper tells no direction (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bump:
    """A contact of the bumper: world frame, robot's clock. `heading_rad`: the robot's heading at first contact."""

    at: complex
    felt_s: float
    heading_rad: float


class Perception:
    """Localisation, object tracking, obstacles and recent memory."""

    def __init__(self, profile: RobotProfile) -> None:
        self._profile = profile
        self.localiser = Localiser(profile.start, profile.beacons)
        self._tracking = ObjectTracking()
        self._borders = Borders(profile.keep_out, profile.one_robot)
        self._bump: Bump | None = None
        self._in_view: Sightings | None = None
        self._looked_s = 0.0
        self._looked_from = profile.start
        self._last_seen: dict[str, LastSight] = {}
        self._things = NONE_IN_VIEW
        self._thing_names: tuple[str, ...] = ()
        self._thing_rows = np.empty(0, np.int64)
        self._measured: tuple[tuple[str, ...], str | None] = ((), None)
        self._lengths_m = np.empty(0)
        self.held: str | None = None
        """What the jaws were last sensed to hold; the gripper is not sensed all the time."""

    def perceive(
        self,
        data: MutualDataStore,
        odometry: Pose,
        now_s: float,
        *,
        battery: float = 1.0,
        charging: bool = False,
        measured: Mapping[str, float] = NOTHING_MEASURED,
        degraded: tuple[Defect, ...] = (),
    ) -> Percepts:
        """Fuse the readings of the running sensors, which `SensorHealth` has checked."""
        sightings: Sightings | None = data.values.get(Sensor.INFRA_RED)
        pose = self.localiser.update(odometry, NONE_IN_VIEW if sightings is None else sightings)
        self._look(sightings, pose, now_s)
        if Sensor.GRIPPER in data.values:
            self.held = data.get(Sensor.GRIPPER).holding
        if data.values.get(Sensor.BUMPER):
            self._bump = self._contact(pose, now_s)
        self._tracking.observe(self._observations(data, pose, now_s), now_s)
        solid, about = self._obstacles(data, pose, now_s)
        return Percepts(
            profile=self._profile,
            time_s=now_s,
            pose=pose,
            odometry=odometry,
            data=data,
            seen=sightings,
            solid=solid,
            about=about,
            cursors=self._tracking.cursors.copy(),
            bumped_s=self._bump.felt_s if self._bump else None,
            battery=battery,
            charging=charging,
            measured=measured,
            degraded=degraded,
            last_seen=self._last_seen,
            last_held=self.held,
        )

    def _look(self, sightings: Sightings | None, pose: Pose, now_s: float) -> None:
        """Separate things in view from places, and note when and where something went out of view."""
        last = self._in_view
        self._in_view = sightings
        known = NONE_IN_VIEW.names if last is None else last.names
        names = NONE_IN_VIEW.names if sightings is None else sightings.names
        if names != known:
            gone = [] if last is None else [last[name] for name in set(known).difference(names)]
            self._last_seen.update((one.identity, self._last_sight(one)) for one in gone)
            rows = [row for row, name in enumerate(names) if name not in self._profile.places]
            self._thing_rows = np.array(rows, np.int64)
            self._thing_names = tuple(names[row] for row in rows)
        self._looked_s = now_s
        self._looked_from = pose
        if sightings is not None:
            self._things = Sightings(self._thing_names, sightings.read[self._thing_rows])

    def _last_sight(self, sighting: Sighting) -> LastSight:
        at = to_world(self._looked_from, rect(sighting.range_m, sighting.bearing_rad))
        return LastSight(self._looked_s, sighting.range_m, at)

    def _observations(self, data: MutualDataStore, pose: Pose, now_s: float) -> Iterator[Observation]:
        """The observations of things by the running sensors."""
        if Sensor.INFRA_RED in data.values:
            yield by_infra_red(self._things, pose)
        if Sensor.ULTRASONIC in data.values:
            yield by_whiskers(data.get(Sensor.ULTRASONIC), pose, self._tracking.cursors)
        if self._bump is not None and self._bump.felt_s == now_s:
            yield by_touch(self._bump.at, self._tracking.cursors)

    def _obstacles(
        self, data: MutualDataStore, pose: Pose, now_s: float
    ) -> tuple[Obstacles | None, Obstacles | None]:
        """Bodies in view, and all obstacles with those of whiskers and bumper; None if a sensor is off."""
        if not data.holds(LOCATING):
            return None, None
        things = self._things
        held = data.get(Sensor.GRIPPER).holding
        if self._measured != (things.names, held):
            self._measured = (things.names, held)
            self._lengths_m = np.array([self._length_m(name, held) for name in things.names], np.float64)
        ranges_m = data.values.get(Sensor.ULTRASONIC)
        more = 0 if ranges_m is None else len(ranges_m) + self._borders.count
        collector = ObstacleCollector(things.read, self._lengths_m, more)
        solid = collector.collected()
        if ranges_m is None:
            return solid, None
        collector.add_hits(ranges_m, self._profile.whisker_least_m)
        for at in self._borders.near(pose, self._fellows(now_s)):
            collector.add(at, BORDER_RADIUS_M)
        if self._bump is not None and now_s - self._bump.felt_s <= REMEMBERED_S:
            # NOTE: it may be below the whiskers' plane.
            collector.add(to_robot(pose, self._bump.at), BUMP_RADIUS_M)
        return solid, collector.collected()

    def _fellows(self, now_s: float) -> Iterator[complex]:
        """Where other robots are, or were last seen not long ago."""
        for name in self._profile.others:
            cursor = self._tracking.cursors.get(name)
            if cursor is not None and now_s - cursor.seen_s <= REMEMBERED_S:
                yield cursor.at

    def _length_m(self, thing: str, held: str | None) -> float:
        """The length that `ObstacleCollector` takes for the body."""
        if thing in self._profile.fellows:
            return ROBOT
        if thing in (held, self._profile.name):
            return NO_OBSTACLE
        return self._profile.lengths_m.get(thing, 0.0)

    def _contact(self, pose: Pose, now_s: float) -> Bump:
        """The present contact; it keeps its direction while they touch."""
        last = self._bump
        still = last is not None and now_s - last.felt_s < CONTACT_GAP_S
        heading_rad = last.heading_rad if last is not None and still else pose.heading_rad
        at = complex(pose.x_m, pose.y_m) + rect(RADIUS_M + BUMP_RADIUS_M, heading_rad)
        return Bump(at=at, felt_s=now_s, heading_rad=heading_rad)
