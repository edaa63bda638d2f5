"""The rovers' simulated sensors: one batch of whisker rays and one of lines of sight for all rovers.

Whiskers (ultrasonic): shape (N,) each, metres from the body's edge, beam 0 ahead, counter-clockwise, inf
where nothing is in range. Infra-red sightings: walls block them, rovers and samples are too low to.
"""

import itertools
from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from math import inf, nan, pi, radians, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import RADIUS_M, Pose
from robots.physical.sightings import Sightings
from robots.world import Location, RobotSpec, Sample
from sim.physics.rays import FREE, LinesOfSight, free_shares
from sim.physics.scene import BEACON_HEIGHT_M, SONAR_GROUPS, WALLS, Scene

WHISKER_HEIGHT_M = 0.1
TAG_RANGE_M = 8.0
RANGE_SIGMA_M = 0.01
BEARING_SIGMA_RAD = radians(0.5)
ASPECT_SIGMA_RAD = radians(1.0)
_EDGE_M = RADIUS_M + 0.002  # rays start just outside the body they belong to

NOWHERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)

Rngs = Mapping[str, np.random.Generator]
Floats = NDArray[np.float64]


class Fans(NamedTuple):
    """The whiskers of F rovers, one after the other: N rays."""

    specs: tuple[RobotSpec, ...]
    counts: NDArray[np.int64]
    """Shape (F,)."""
    bounds: NDArray[np.int64]
    """Shape (F + 1,): rover f has the rays `bounds[f]` to `bounds[f + 1]`."""
    beams_rad: Floats
    """Shape (N,), from straight ahead; the following likewise."""
    range_m: Floats
    least_m: Floats

    @classmethod
    def of(cls, specs: tuple[RobotSpec, ...]) -> "Fans":
        counts = np.array([spec.whiskers for spec in specs])
        return cls(
            specs=specs,
            counts=counts,
            bounds=np.concatenate([[0], np.cumsum(counts)]),
            beams_rad=np.concatenate([np.arange(count) * tau / count for count in counts]),
            range_m=np.repeat([spec.whisker_range_m for spec in specs], counts),
            least_m=np.repeat([spec.whisker_least_m for spec in specs], counts),
        )


class Whiskers:
    """The ultrasonic arrays of all rovers, read in one batch."""

    def __init__(self, specs: Sequence[RobotSpec]) -> None:
        self._specs = tuple(specs)
        self._fans: Fans | None = None
        self._unfitted = {s.name: np.full(s.whiskers, inf) for s in specs if "real" not in s.sonar}

    def read(
        self, scene: Scene, poses: Mapping[str, Pose], rngs: Rngs, running: Container[str]
    ) -> dict[str, Floats]:
        """Ranges by rover whose array runs; no rays are cast for the others, nor for those without a real array."""
        unfitted = {name: ranges for name, ranges in self._unfitted.items() if name in running}
        specs = tuple([spec for spec in self._specs if spec.name in running and spec.name not in unfitted])
        if not specs:
            return unfitted
        if self._fans is None or self._fans.specs != specs:
            self._fans = Fans.of(specs)
        fans = self._fans
        at = np.repeat(_rows(poses[spec.name] for spec in specs), fans.counts, axis=0)
        directions = _unit(at[:, 2] + fans.beams_rad)
        starts = at[:, :2] + _EDGE_M * directions
        ends = at[:, :2] + (_EDGE_M + fans.range_m)[:, None] * directions
        cut = scene.cut(height_m=WHISKER_HEIGHT_M, groups=SONAR_GROUPS)
        free = free_shares(cut, starts, ends, fans.bounds)
        noise = np.concatenate([rngs[spec.name].standard_normal(spec.whiskers) for spec in specs])
        measured = np.maximum(fans.least_m, free * fans.range_m + RANGE_SIGMA_M * noise)
        ranges = np.where(free < FREE, measured, inf)
        spans = itertools.pairwise(fans.bounds.tolist())
        return unfitted | {
            spec.name: ranges[first:last] for spec, (first, last) in zip(specs, spans, strict=True)
        }


class InfraRed:
    """The beacon sensors of all rovers, read in one batch.

    Emitters are beacons, rovers, the samples' tags and robots that are not simulated, in this order. A rover sees the
    beacons of its reach, the other robots, and every tag that is near enough and not hidden in its own jaws. A compact
    sample's tag has no axis; a long one's, at its middle, emits to both sides.

    :param beacons: the places; each has a beacon that emits along its approach directions.
    :param reach: the names of the beacons that each rover knows.
    :param foreign: the robots that are not simulated.
    """

    def __init__(
        self,
        beacons: Sequence[Location],
        reach: Mapping[str, Collection[str]],
        samples: Sequence[Sample],
        foreign: Sequence[str] = (),
    ) -> None:
        self._rovers = {rover: row for row, rover in enumerate(reach)}
        names = [sample.name for sample in samples]
        self._identities = [*(beacon.name for beacon in beacons), *reach, *names, *foreign]
        self._foreign = tuple(foreign)
        self._tags = {name: len(beacons) + len(reach) + n for n, name in enumerate(names)}
        self._long = [sample.name for sample in samples if sample.length_m]
        self._fixed = np.array([beacon.at for beacon in beacons]).reshape(-1, 2)
        self._axes_rad = _padded_rad([beacon.approach_deg for beacon in beacons], len(self._identities))
        self._reach_m = np.full(len(self._identities), inf)
        self._reach_m[list(self._tags.values())] = TAG_RANGE_M
        self._known = np.ones((len(reach), len(self._identities)), np.bool_)
        for row, known in enumerate(reach.values()):
            self._known[row, : len(beacons)] = [beacon.name in known for beacon in beacons]
            self._known[row, len(beacons) + row] = False
        self._lines = LinesOfSight(*self._known.shape)
        self._has_read = False

    def read(
        self,
        scene: Scene,
        poses: Mapping[str, Pose],
        rngs: Rngs,
        running: Collection[str],
        hidden: Iterable[tuple[str, str]],
        foreign: Mapping[str, Pose] | None = None,
    ) -> dict[str, Sightings]:
        """Sightings by rover whose sensor runs.

        :param hidden: rovers and the samples in their jaws whose tags they do not see.
        :param foreign: where robots that are not simulated are, as far as that is known.
        """
        if not self._rovers or (not running and self._has_read):  # the first call compiles, even for nothing
            return {}
        self._has_read = True
        at = _rows(poses.values())
        emitters_at = np.concatenate([self._fixed, at[:, :2], scene.sample_points()[:, :2]])
        known = self._known & np.array([[rover in running] for rover in self._rovers])
        if self._foreign:
            there = foreign or {}
            emitters_at = np.concatenate(
                [emitters_at, _rows(there.get(n, NOWHERE) for n in self._foreign)[:, :2]]
            )
            known[:, -len(self._foreign) :] &= np.array([name in there for name in self._foreign])
        for rover, sample in hidden:
            known[self._rovers[rover], self._tags[sample]] = False
        for sample in self._long:
            along_rad = scene.sample_heading(sample)
            self._axes_rad[self._tags[sample], :2] = (along_rad + pi / 2, along_rad - pi / 2)
        walls = scene.cut(height_m=BEACON_HEIGHT_M, groups=WALLS)
        pairs = self._lines.read(walls, at[:, :2], emitters_at, self._reach_m, known)
        rovers = pairs[:, 0]
        emitters = pairs[:, 1]
        counts = np.bincount(rovers, minlength=len(self._rovers))
        noise = [rngs[rover].standard_normal((counts[row], 3)) for rover, row in self._rovers.items()]
        read = _measured(at[rovers], emitters_at[emitters], self._axes_rad[emitters], np.concatenate(noise))
        names = [self._identities[n] for n in emitters.tolist()]
        ends = np.cumsum(counts).tolist()
        spans = {rover: slice(ends[row] - counts[row], ends[row]) for rover, row in self._rovers.items()}
        return {rover: Sightings(tuple(names[spans[rover]]), read[spans[rover]]) for rover in running}


def aspect_rad(observers: Floats, emitters: Floats, axes_rad: Floats) -> Floats:
    """Angle of each observer off its emitter's nearest axis, counter-clockwise positive; 0 without an axis.

    :param observers, emitters: shape (N, 2), metres. :param axes_rad: shape (N, A), NaN where there are fewer.
    """
    around = np.arctan2(observers[:, 1] - emitters[:, 1], observers[:, 0] - emitters[:, 0])
    off = _wrapped(around[:, None] - axes_rad)
    size = np.where(np.isnan(off), inf, np.abs(off))
    nearest = np.take_along_axis(off, np.argmin(size, axis=1)[:, None], axis=1)[:, 0]
    return np.nan_to_num(nearest)


def _measured(observers: Floats, emitters: Floats, axes_rad: Floats, noise: Floats) -> Floats:
    """Range, bearing and aspect as the sensor measures them, shape (N, 3), of pairs in line of sight."""
    offsets = emitters - observers[:, :2]
    range_m = np.hypot(offsets[:, 0], offsets[:, 1]) + RANGE_SIGMA_M * noise[:, 0]
    bearing = np.arctan2(offsets[:, 1], offsets[:, 0]) - observers[:, 2]
    aspect = aspect_rad(observers, emitters, axes_rad) + ASPECT_SIGMA_RAD * noise[:, 2]
    has_axis = ~np.isnan(axes_rad[:, 0])
    return np.column_stack(
        [
            np.maximum(0.0, range_m),
            _wrapped(bearing + BEARING_SIGMA_RAD * noise[:, 1]),
            np.where(has_axis, _wrapped(aspect), 0.0),
        ]
    )


def _rows(poses: Iterable[Pose]) -> Floats:
    """Shape (N, 3): x and y in metres, heading in radians."""
    return np.array([(pose.x_m, pose.y_m, pose.heading_rad) for pose in poses]).reshape(-1, 3)


def _unit(angles_rad: Floats) -> Floats:
    return np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])


def _wrapped(angles_rad: Floats) -> Floats:
    return angles_rad - tau * np.rint(angles_rad / tau)


def _padded_rad(axes_deg: Sequence[Sequence[float]], rows: int) -> Floats:
    """Shape (rows, A >= 2): a row an emitter, NaN where it has fewer axes."""
    padded = np.full((rows, max([2, *map(len, axes_deg)])), nan)
    for row, axes in enumerate(axes_deg):
        padded[row, : len(axes)] = np.radians(axes)
    return padded
