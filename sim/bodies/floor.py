"""How much room there is on the floor: what a body goes by that nothing stops."""

from collections.abc import Sequence
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from robots.body import RADIUS_M, Pose
from robots.world.walls import WALL_THICKNESS_M, Panel
from sim.physics.scene import SAMPLE_RADIUS_M
from sim.physics.shapes import front_m
from sim.world.placement import Rock

JAW_M = SAMPLE_RADIUS_M
"""Half the jaws' breadth."""
FRONT_M = front_m(JAW_M)
"""From the body's middle to the jaws' front."""

Points = NDArray[np.float64]
"""Shape (N, 2), metres, world frame; a single point (2,)."""


class FloorMap:
    """Walls, closed doors and rocks, as they stand. Other robots and samples are not on it."""

    def __init__(self, panels: Sequence[Panel], rocks: Sequence[Rock] = ()) -> None:
        self._starts: Points = np.array([panel.start for panel in panels], dtype=np.float64).reshape(-1, 2)
        self._ends: Points = np.array([panel.end for panel in panels], dtype=np.float64).reshape(-1, 2)
        self._rocks: Points = np.array([rock.point for rock in rocks], dtype=np.float64).reshape(-1, 2)
        self._rock_radii_m = np.array([rock.radius_m for rock in rocks], dtype=np.float64)

    def room_m(self, pose: Pose) -> float:
        """From a rover's hull or jaws, whichever is nearer, to what stands next; negative if they overlap.

        The jaws are taken as rounded off in front (our choice).
        """
        middle = np.array([pose.x_m, pose.y_m])
        ahead = np.array([cos(pose.heading_rad), sin(pose.heading_rad)])
        tip = middle + (FRONT_M - JAW_M) * ahead
        edges = np.concatenate((self._starts, self._ends))
        to_wall_m = (
            _least(_off(middle, self._starts, self._ends)) - RADIUS_M,
            _least(_off(tip, self._starts, self._ends)) - JAW_M,
            _least(_off(edges, middle, tip)) - JAW_M,
        )
        to_rock_m = (
            _least(np.hypot(*(self._rocks - middle).T) - self._rock_radii_m) - RADIUS_M,
            _least(_off(self._rocks, middle, tip) - self._rock_radii_m) - JAW_M,
        )
        return min(min(to_wall_m) - WALL_THICKNESS_M / 2, *to_rock_m)


def _off(points: Points, starts: Points, ends: Points) -> NDArray[np.float64]:
    """From points to the nearest points of segments, one each or one for all; shape (N,), metres."""
    along = ends - starts
    share = ((points - starts) * along).sum(-1) / (along * along).sum(-1)
    nearest = starts + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.hypot(*(points - nearest).T))


def _least(distances_m: NDArray[np.float64]) -> float:
    return float(distances_m.min(initial=np.inf))
