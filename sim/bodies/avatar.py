"""The virtual avatar (SRA, Virtual Robotic Workbench): a robot without a physical body, which moves by itself.

It collides with nothing; other robots see its beacon; only virtual sonar detects it. The floor map alone stops it, with
the panels of doors, hatches and lifts that are down at the time.
Its jaws work as all jaws do (our choice): what they hold goes with them.
"""

from collections.abc import Iterable, Sequence
from math import cos, hypot, inf, remainder, sin, tau

import numpy as np
from numpy.typing import NDArray

from robots.physical.body import RADIUS_M, Pose
from robots.world import RobotSpec
from robots.world.bodies import Ramps
from robots.world.walls import WALL_THICKNESS_M, Panel
from sim.bodies.odometry import Odometry, advance_pose
from sim.bodies.velocity import RampedBody
from sim.clock import TICK_S
from sim.physics.bullet import front_m
from sim.physics.jaws import Jaws
from sim.physics.scene import SAMPLE_RADIUS_M, Scene
from sim.snapshot import Rock

JAW_M = SAMPLE_RADIUS_M
"""Half the jaws' breadth."""
FRONT_M = front_m(JAW_M)
"""From the body's middle to the jaws' front."""

Points = NDArray[np.float64]
"""Shape (N, 2), metres, world frame; a single point (2,)."""


_AS_COMPLEX = np.array([1, 1j])


class FloorMap:
    """Walls, closed doors and rocks. Other robots and samples are not on it."""

    def __init__(self, panels: Sequence[Panel], rocks: Sequence[Rock] = ()) -> None:
        self._starts = _points(panel.start for panel in panels)
        self._ends = _points(panel.end for panel in panels)
        self._rocks = _points(rock.point for rock in rocks)
        self._rock_radii_m = np.array([rock.radius_m for rock in rocks], dtype=np.float64)

    @property
    def walls(self) -> NDArray[np.complex128]:
        """Shape (M, 2), the ends of each wall's middle line, world frame, metres."""
        return np.stack((self._starts @ _AS_COMPLEX, self._ends @ _AS_COMPLEX), axis=1)

    def clearance_m(self, pose: Pose) -> float:
        """Distance from a rover's hull or jaws to the nearest obstacle; negative if they overlap.

        The jaws' front is taken as rounded (our choice).
        """
        middle = np.array([pose.x_m, pose.y_m])
        ahead = np.array([cos(pose.heading_rad), sin(pose.heading_rad)])
        tip = middle + (FRONT_M - JAW_M) * ahead
        edges = np.concatenate((self._starts, self._ends))
        to_wall_m = (
            _least(_distances_m(middle, self._starts, self._ends)) - RADIUS_M,
            _least(_distances_m(tip, self._starts, self._ends)) - JAW_M,
            _least(_distances_m(edges, middle, tip)) - JAW_M,
        )
        to_rock_m = (
            _least(np.hypot(*(self._rocks - middle).T) - self._rock_radii_m) - RADIUS_M,
            _least(_distances_m(self._rocks, middle, tip) - self._rock_radii_m) - JAW_M,
        )
        return min(min(to_wall_m) - WALL_THICKNESS_M / 2, *to_rock_m)


class AvatarBody(RampedBody):
    """Integrates its own pose; the part of a step that would end in an obstacle is not made."""

    def __init__(
        self, spec: RobotSpec, ramps: Ramps, jaws: Jaws, scene: Scene, odometry: Odometry, floor: FloorMap
    ) -> None:
        super().__init__(spec, ramps, jaws, scene, odometry)
        self._floor = floor
        self._blocked = False
        self._lowered = scene.lowered_panels
        self._doors = FloorMap(tuple(self._lowered))
        self._measured_at = scene.pose(spec.name)
        self._clearance_m = self._room_m(self._measured_at)
        scene.make_intangible(spec.name)

    def drive(self) -> None:
        self._ramp()
        self._blocked = False
        if self._driven != (0.0, 0.0):
            self._scene.put_rover(self.spec.name, self._next(self._scene.pose(self.spec.name)))

    def touches(self) -> bool:
        """True while a wall stops it."""
        return self._blocked

    def _next(self, pose: Pose) -> Pose:
        """The pose after the whole step; if an obstacle is in its way after the turn or the translation alone."""
        self._notice_panels()
        ahead_m = self._driven[0] * TICK_S
        turn_rad = self._driven[1] * TICK_S
        for step in ((ahead_m, turn_rad), (0.0, turn_rad), (ahead_m, 0.0)):
            then = advance_pose(pose, *step)
            if self._is_free(then) or self._room_m(then) >= self._room_m(pose):
                return then
            self._blocked = True
        return pose

    def _notice_panels(self) -> None:
        """Forget the clearance measured last time if a panel has risen or sunk since."""
        if self._scene.lowered_panels != self._lowered:
            self._lowered = self._scene.lowered_panels
            self._doors = FloorMap(tuple(self._lowered))
            self._clearance_m = -inf

    def _room_m(self, pose: Pose) -> float:
        return min(self._floor.clearance_m(pose), self._doors.clearance_m(pose))

    def _is_free(self, then: Pose) -> bool:
        """Whether it is clear there. The map is read only beyond the clearance measured last time."""
        moved_m = hypot(then.x_m - self._measured_at.x_m, then.y_m - self._measured_at.y_m)
        moved_m += FRONT_M * abs(remainder(then.heading_rad - self._measured_at.heading_rad, tau))
        if moved_m >= self._clearance_m:
            self._measured_at = then
            self._clearance_m = self._room_m(then)
            return self._clearance_m >= 0
        return True


def _points(points: Iterable[tuple[float, float]]) -> Points:
    return np.array(list(points), dtype=np.float64).reshape(-1, 2)


def _distances_m(points: Points, starts: Points, ends: Points) -> NDArray[np.float64]:
    """From points to the nearest points of segments, one each or one for all; shape (N,)."""
    along = ends - starts
    share = ((points - starts) * along).sum(-1) / (along * along).sum(-1)
    nearest = starts + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.hypot(*(points - nearest).T))


def _least(distances_m: NDArray[np.float64]) -> float:
    return float(distances_m.min(initial=np.inf))
