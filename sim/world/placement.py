"""Initial poses of rovers, samples and rocks, drawn by a seed or read from a snapshot."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, dist, radians, remainder, sin, sqrt, tau

import numpy as np

from robots.physical.body import RADIUS_M, Pose
from robots.world import RobotSpec, Sample, WorldFile
from robots.world.walls import Panel, clearance_m
from sim.physics.scene import Placed
from sim.snapshot import Rock, WorldSnapshot

WALL_CLEARANCE_M = RADIUS_M + 0.2  # room to turn with the jaws ahead
BODY_CLEARANCE_M = 2 * RADIUS_M + 0.2
SAMPLE_CLEARANCE_M = RADIUS_M + 0.2
TOLD_SIGMA_M = 0.03
TOLD_SIGMA_RAD = radians(2)
SAMPLE_SIGMA_M = 0.01
MAX_DRAWS = 1000
ADDED_JITTER_M = 0.4
"""How far from its start a rover may stand that is added while the world runs: another one may be there."""
NOBODY: Mapping[str, Pose] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """The poses that the world file does not fix, and the start pose each rover was told."""

    rocks: tuple[Rock, ...]
    rovers: Mapping[str, Pose]
    samples: Mapping[str, Placed]
    told: Mapping[str, Pose]

    @classmethod
    def draw(
        cls, world: WorldFile, panels: Sequence[Panel], rng: np.random.Generator, jitter_m: float
    ) -> "Placement":
        """Drawn at random."""
        rocks = rocks_of(world, rng)
        starts = StartPoses(world=world, panels=panels, rocks=rocks, rng=rng, jitter_m=jitter_m).draw()
        samples = placed_samples(world, world.samples, rng)
        told = {name: told_pose(pose, rng) for name, pose in starts.items()}
        return cls(rocks=rocks, rovers=starts, samples=samples, told=told)

    @classmethod
    def restore(
        cls,
        world: WorldFile,
        samples: Sequence[Sample],
        snapshot: WorldSnapshot,
        panels: Sequence[Panel],
        rng: np.random.Generator,
    ) -> "Placement":
        """Read from a snapshot. What it does not have was added to the world since: that is drawn as at a start.

        :param samples: all that there are, known or not.
        """
        known = {one.name: one for one in samples}
        lying = {
            name: Placed(
                state.point,
                known[name].length_m,
                state.heading_rad,
                known[name].rolling_m_s2,
                state.velocity_m_s,
            )
            for name, state in snapshot.samples.items()
        }
        starts = StartPoses(
            world=world, panels=panels, rocks=snapshot.rocks, rng=rng, jitter_m=ADDED_JITTER_M
        )
        # A robot that was foreign until now goes on where it was last reported.
        simulated = {spec.name for spec in world.simulated}
        reported = {name: pose for name, pose in snapshot.foreign.robots.items() if name in simulated}
        rovers = starts.draw({**reported, **snapshot.rovers})
        told = {name: told_pose(pose, rng) for name, pose in rovers.items() if name not in snapshot.told}
        new = placed_samples(world, [one for one in samples if one.name not in lying], rng)
        return cls(
            rocks=snapshot.rocks,
            rovers=rovers,
            samples={one.name: lying.get(one.name) or new[one.name] for one in samples},
            told={**snapshot.told, **told},
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StartPoses:
    """Start poses within `jitter_m` of the world file's, in the rover's area, clear of everything, with any heading.

    Without jitter, or where no clear pose is found, the world file's own start.
    """

    world: WorldFile
    panels: Sequence[Panel]
    rocks: Sequence[Rock]
    rng: np.random.Generator
    jitter_m: float

    def draw(self, placed: Mapping[str, Pose] = NOBODY) -> dict[str, Pose]:
        """A pose a rover, for those that stand somewhere already the pose there. The starts of rovers that are not
        placed yet are kept free.
        """
        poses = {spec.name: placed.get(spec.name) or _file_start(spec) for spec in self.world.simulated}
        if self.jitter_m > 0:
            for spec in (spec for spec in self.world.simulated if spec.name not in placed):
                others = [pose for name, pose in poses.items() if name != spec.name]
                poses[spec.name] = self._draw_one(spec, poses[spec.name], others)
        return poses

    def _draw_one(self, spec: RobotSpec, start: Pose, others: Sequence[Pose]) -> Pose:
        for _ in range(MAX_DRAWS):
            x_m, y_m = _within((start.x_m, start.y_m), self.jitter_m, self.rng)
            pose = Pose(x_m=x_m, y_m=y_m, heading_rad=remainder(tau * self.rng.random(), tau))
            if self._is_clear(spec, (x_m, y_m), others):
                return pose
        return start

    def _is_clear(self, spec: RobotSpec, point: tuple[float, float], others: Sequence[Pose]) -> bool:
        lying = self.world.initial_places
        reach = [
            (self.world.location(lying[one.name]).at, SAMPLE_CLEARANCE_M + one.length_m / 2)
            for one in self.world.samples
        ]
        return (
            self.world.area_of(spec).contains(point)
            and clearance_m(point, self.panels) >= WALL_CLEARANCE_M
            and all(dist(point, (other.x_m, other.y_m)) >= BODY_CLEARANCE_M for other in others)
            and all(dist(point, at) >= reach_m for at, reach_m in reach)
            and all(dist(point, rock.point) - rock.radius_m >= WALL_CLEARANCE_M for rock in self.rocks)
        )


def told_pose(true: Pose, rng: np.random.Generator) -> Pose:
    """The start pose a rover is told: approximately true."""
    noise = rng.standard_normal(3).tolist()
    return Pose(
        x_m=true.x_m + TOLD_SIGMA_M * noise[0],
        y_m=true.y_m + TOLD_SIGMA_M * noise[1],
        heading_rad=remainder(true.heading_rad + TOLD_SIGMA_RAD * noise[2], tau),
    )


def rocks_of(world: WorldFile, rng: np.random.Generator) -> tuple[Rock, ...]:
    """The obstacles at the world file's points, each within its own jitter."""
    return tuple(
        Rock(_within(one.at, one.jitter_m, rng) if one.jitter_m else one.at, one.radius_m)
        for one in world.obstacles
    )


def placed_samples(
    world: WorldFile, samples: Sequence[Sample], rng: np.random.Generator
) -> dict[str, Placed]:
    """The samples at their locations, within about a centimetre; long ones lie across the first approach direction."""
    placed = {}
    for sample in samples:
        place = world.location(world.initial_places.get(sample.name, sample.at))
        noise = SAMPLE_SIGMA_M * rng.standard_normal(2)
        point = (place.at[0] + float(noise[0]), place.at[1] + float(noise[1]))
        across_rad = radians(place.approach_deg[0] + 90) if sample.length_m else 0.0
        placed[sample.name] = Placed(point, sample.length_m, across_rad, sample.rolling_m_s2)
    return placed


def _within(middle: tuple[float, float], reach_m: float, rng: np.random.Generator) -> tuple[float, float]:
    """A uniformly distributed point within reach of another."""
    distance_m = reach_m * sqrt(rng.random())
    angle_rad = tau * rng.random()
    return (middle[0] + distance_m * cos(angle_rad), middle[1] + distance_m * sin(angle_rad))


def _file_start(spec: RobotSpec) -> Pose:
    x, y, heading_deg = spec.start
    return Pose(x_m=x, y_m=y, heading_rad=remainder(radians(heading_deg), tau))
