"""Start poses: where a seed puts the rovers, and what they are told about it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, dist, hypot, radians, remainder, sin, sqrt, tau

import numpy as np

from robots.body import RADIUS_M, Pose
from robots.world import RobotSpec, WorldFile
from robots.world.walls import Panel, clearance_m
from sim.physics.scene import Placed
from sim.snapshot import WorldSnapshot

WALL_CLEARANCE_M = RADIUS_M + 0.2  # room to turn with the jaws ahead
BODY_CLEARANCE_M = 2 * RADIUS_M + 0.2
SAMPLE_CLEARANCE_M = RADIUS_M + 0.2
TOLD_SIGMA_M = 0.03
TOLD_SIGMA_RAD = radians(2)
SAMPLE_SIGMA_M = 0.01
_TRIES = 1000


@dataclass(frozen=True, slots=True)
class Rock:
    """Where a seed puts an obstacle: metres in the world's frame."""

    point: tuple[float, float]
    radius_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Where everything is that the world file does not fix, and what each rover was told of its start."""

    rocks: tuple[Rock, ...]
    rovers: Mapping[str, Pose]
    samples: Mapping[str, Placed]
    told: Mapping[str, Pose]

    @classmethod
    def drawn(
        cls, world: WorldFile, panels: Sequence[Panel], rng: np.random.Generator, jitter_m: float
    ) -> "Places":
        """As a seed has it."""
        rocks = rocks_of(world, rng)
        starts = StartPlaces(world=world, panels=panels, rocks=rocks, rng=rng, jitter_m=jitter_m).poses()
        samples = placed_samples(world, rng)
        told = {name: told_pose(pose, rng) for name, pose in starts.items()}
        return cls(rocks=rocks, rovers=starts, samples=samples, told=told)

    @classmethod
    def kept(cls, world: WorldFile, snapshot: WorldSnapshot) -> "Places":
        """As a snapshot has it."""
        lying = {one.name: snapshot.samples[one.name] for one in world.samples}
        return cls(
            rocks=tuple(Rock(rock.point, rock.radius_m) for rock in snapshot.rocks),
            rovers={spec.name: snapshot.rovers[spec.name] for spec in world.robots},
            samples={
                one.name: Placed(lying[one.name].point, one.length_m, lying[one.name].heading_rad)
                for one in world.samples
            },
            told=snapshot.told,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StartPlaces:
    """Draws start poses: within `jitter_m` of the world file's, in its area, clear of all, any heading.

    Without jitter, or where no clear place is found, the world file's own start.
    """

    world: WorldFile
    panels: Sequence[Panel]
    rocks: Sequence[Rock]
    rng: np.random.Generator
    jitter_m: float

    def poses(self) -> dict[str, Pose]:
        """A pose a rover. The file's starts are kept free for those that are not placed yet."""
        poses = {spec.name: _file_start(spec) for spec in self.world.robots}
        if self.jitter_m > 0:
            for spec in self.world.robots:
                others = [pose for name, pose in poses.items() if name != spec.name]
                poses[spec.name] = self._draw(spec, poses[spec.name], others)
        return poses

    def _draw(self, spec: RobotSpec, start: Pose, others: Sequence[Pose]) -> Pose:
        for _ in range(_TRIES):
            x_m, y_m = _within((start.x_m, start.y_m), self.jitter_m, self.rng)
            pose = Pose(x_m=x_m, y_m=y_m, heading_rad=remainder(tau * self.rng.random(), tau))
            if self._clear(spec, (pose.x_m, pose.y_m), others):
                return pose
        return start

    def _clear(self, spec: RobotSpec, point: tuple[float, float], others: Sequence[Pose]) -> bool:
        bodies = [(other.x_m, other.y_m) for other in others]
        lying, samples = self.world.lying, self.world.samples
        reach = [
            (self.world.location(lying[one.name]).at, SAMPLE_CLEARANCE_M + one.length_m / 2)
            for one in samples
        ]
        return (
            self.world.area_of(spec).contains(point)
            and clearance_m(point, self.panels) >= WALL_CLEARANCE_M
            and all(hypot(point[0] - x, point[1] - y) >= BODY_CLEARANCE_M for x, y in bodies)
            and all(hypot(point[0] - x, point[1] - y) >= reach_m for (x, y), reach_m in reach)
            and all(dist(point, rock.point) - rock.radius_m >= WALL_CLEARANCE_M for rock in self.rocks)
        )


def told_pose(true: Pose, rng: np.random.Generator) -> Pose:
    """What a rover is told of its start: approximately true."""
    noise = rng.standard_normal(3)
    return Pose(
        x_m=true.x_m + TOLD_SIGMA_M * noise[0],
        y_m=true.y_m + TOLD_SIGMA_M * noise[1],
        heading_rad=remainder(true.heading_rad + TOLD_SIGMA_RAD * noise[2], tau),
    )


def rocks_of(world: WorldFile, rng: np.random.Generator) -> tuple[Rock, ...]:
    """Where the obstacles stand: at the world file's points, each within its own jitter."""
    return tuple(
        Rock(_within(one.at, one.jitter_m, rng) if one.jitter_m else one.at, one.radius_m)
        for one in world.obstacles
    )


def placed_samples(world: WorldFile, rng: np.random.Generator) -> dict[str, Placed]:
    """Where the samples stand at the start: at their locations, within about a centimetre; long ones lie across
    their location's first approach direction.
    """
    placed = {}
    for sample in world.samples:
        place = world.location(world.lying[sample.name])
        noise = SAMPLE_SIGMA_M * rng.standard_normal(2)
        point = (place.at[0] + float(noise[0]), place.at[1] + float(noise[1]))
        across_rad = radians(place.approach_deg[0] + 90) if sample.length_m else 0.0
        placed[sample.name] = Placed(point, sample.length_m, across_rad)
    return placed


def _within(middle: tuple[float, float], reach_m: float, rng: np.random.Generator) -> tuple[float, float]:
    """A point within reach of another, any as likely as any other."""
    away, around = reach_m * sqrt(rng.random()), tau * rng.random()
    return (middle[0] + away * cos(around), middle[1] + away * sin(around))


def _file_start(spec: RobotSpec) -> Pose:
    x, y, heading_deg = spec.start
    return Pose(x_m=x, y_m=y, heading_rad=remainder(radians(heading_deg), tau))
