"""What rovers sense of the scene: one batch of whisker rays and one of lines of sight for all of them.

Whiskers (ultrasonic): shape (N,) each, metres from the body's edge, beam 0 ahead, counter-clockwise, inf
where nothing is in range. Infra-red sightings: walls block them, rovers and samples are too low to.
"""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, radians, remainder, sin, tau

import numpy as np
from numpy.typing import NDArray

from robots.body import RADIUS_M, Pose, Sighting
from robots.world import RobotSpec
from sim.scene import AUDIBLE, WALLS, Point3, Scene

BEACON_HEIGHT_M = 0.5
WHISKER_HEIGHT_M = 0.1
TAG_RANGE_M = 8.0
RANGE_SIGMA_M = 0.01
BEARING_SIGMA_RAD = radians(0.5)
ASPECT_SIGMA_RAD = radians(1.0)
_EDGE_M = RADIUS_M + 0.002  # rays start just outside the body they belong to


@dataclass(frozen=True, slots=True, kw_only=True)
class Emitter:
    """Something that shines in infra-red: a beacon with emitting axes (world frame), a robot or a tag."""

    identity: str
    x_m: float
    y_m: float
    axes_rad: tuple[float, ...] = ()
    reach_m: float = inf


class Whiskers:
    """The ultrasonic arrays of all rovers, read in one batch."""

    def __init__(self, specs: Sequence[RobotSpec]) -> None:
        self._specs = tuple(specs)

    def read(
        self,
        scene: Scene,
        poses: Mapping[str, Pose],
        rngs: Mapping[str, np.random.Generator],
        running: Container[str],
    ) -> dict[str, NDArray[np.float64]]:
        """One array of ranges a rover whose array runs; no rays are cast for the others."""
        specs = [spec for spec in self._specs if spec.name in running]
        starts: list[Point3] = []
        ends: list[Point3] = []
        for spec in specs:
            _add_fan(starts, ends, poses[spec.name], spec)
        free = np.asarray(scene.cast(starts, ends, mask=AUDIBLE))
        ranges: dict[str, NDArray[np.float64]] = {}
        first = 0
        for spec in specs:
            beams = free[first : first + spec.whiskers]
            noise = RANGE_SIGMA_M * rngs[spec.name].standard_normal(spec.whiskers)
            heard = np.maximum(spec.whisker_least_m, beams * spec.whisker_range_m + noise)
            ranges[spec.name] = np.where(beams < 1.0, heard, inf)
            first += spec.whiskers
        return ranges


def _add_fan(starts: list[Point3], ends: list[Point3], pose: Pose, spec: RobotSpec) -> None:
    far_m = _EDGE_M + spec.whisker_range_m
    for beam in range(spec.whiskers):
        angle = pose.heading_rad + beam * tau / spec.whiskers
        ahead, left = cos(angle), sin(angle)
        starts.append((pose.x_m + _EDGE_M * ahead, pose.y_m + _EDGE_M * left, WHISKER_HEIGHT_M))
        ends.append((pose.x_m + far_m * ahead, pose.y_m + far_m * left, WHISKER_HEIGHT_M))


def sightings(
    scene: Scene,
    poses: Mapping[str, Pose],
    emitters: Mapping[str, Sequence[Emitter]],
    rngs: Mapping[str, np.random.Generator],
) -> dict[str, tuple[Sighting, ...]]:
    """What each rover sees of its own emitters: those in reach and in line of sight."""
    pairs = [
        (rover, emitter)
        for rover, seen in emitters.items()
        for emitter in seen
        if _distance_m(poses[rover], emitter) <= emitter.reach_m
    ]
    free = scene.cast(
        [(poses[rover].x_m, poses[rover].y_m, BEACON_HEIGHT_M) for rover, _ in pairs],
        [(emitter.x_m, emitter.y_m, BEACON_HEIGHT_M) for _, emitter in pairs],
        mask=WALLS,
    )
    seen: dict[str, list[Sighting]] = {rover: [] for rover in emitters}
    for (rover, emitter), share in zip(pairs, free, strict=True):
        if share >= 1.0:
            seen[rover].append(_sighting(poses[rover], emitter, rngs[rover]))
    return {rover: tuple(found) for rover, found in seen.items()}


def aspect_rad(observer: Pose, emitter: Emitter) -> float:
    """How far the observer stands off the nearest emitting axis, counter-clockwise positive; else 0."""
    around = atan2(observer.y_m - emitter.y_m, observer.x_m - emitter.x_m)
    return min((remainder(around - axis, tau) for axis in emitter.axes_rad), key=abs, default=0.0)


def _sighting(observer: Pose, emitter: Emitter, rng: np.random.Generator) -> Sighting:
    noise = rng.standard_normal(3)
    toward = atan2(emitter.y_m - observer.y_m, emitter.x_m - observer.x_m)
    aspect = aspect_rad(observer, emitter) + ASPECT_SIGMA_RAD * noise[2] if emitter.axes_rad else 0.0
    return Sighting(
        identity=emitter.identity,
        range_m=max(0.0, _distance_m(observer, emitter) + RANGE_SIGMA_M * noise[0]),
        bearing_rad=remainder(toward - observer.heading_rad + BEARING_SIGMA_RAD * noise[1], tau),
        aspect_rad=remainder(aspect, tau),
    )


def _distance_m(observer: Pose, emitter: Emitter) -> float:
    return hypot(emitter.x_m - observer.x_m, emitter.y_m - observer.y_m)
