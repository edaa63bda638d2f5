"""The robot's surroundings: a certainty grid that whisker readings fill and clear, and robots seen in infra-red.

The grid is Borenstein & Koren's histogramic in-motion mapping (IEEE Trans. Robotics and Automation 7(4), 1991), which
VFH+ builds on: a hit raises its cell's certainty, the cells short of it are lowered. Our choices: cells of 0.1 m in
odometry's frame, which drifts but does not jump; our whiskers give no false echoes, so a hit counts for more.
"""

from cmath import rect
from math import tau

import numpy as np
from numpy.typing import NDArray

from robots.perception.percepts import Percepts
from robots.physical.body import GRIPPER_REACH_M, RADIUS_M, Pose

CELL_M = 0.1
CELLS = 41
"""Cells a side; the robot is in the middle one, so it remembers 2 m around."""
HIT = 5.0
MISS = -1.0
SURE = 15.0

Points = NDArray[np.complex128]
Numbers = NDArray[np.float64]


class Surroundings:
    """Keeps the grid. `points` (K,) complex, metres, robot's frame; `radii_m` (K,); `certainty` (K,) in (0, 1].

    Another robot counts as a disc with the reach of its jaws, for it may turn.
    """

    def __init__(self) -> None:
        self._certainty = np.zeros((CELLS, CELLS))  # [east, north] of odometry's frame
        self._corner: tuple[int, int] | None = None  # the first cell's number, east and north
        self.points: Points = np.empty(0, dtype=np.complex128)
        self.radii_m: Numbers = np.empty(0)
        self.certainty: Numbers = np.empty(0)

    def update(self, percepts: Percepts) -> None:
        """Account for one tick's whiskers and sightings."""
        here = percepts.odometry
        self._scroll(here)
        turn = rect(1.0, here.heading_rad)
        hits = percepts.obstacles.at[~percepts.obstacles.robots]
        self._count(_beams(percepts) * turn, here, MISS)
        self._count(hits * turn, here, HIT)
        self._gather(percepts, here)

    def _scroll(self, here: Pose) -> None:
        """Keep the robot in the middle cell; cells that enter at an edge are unknown."""
        half = CELLS // 2
        corner = (round(here.x_m / CELL_M) - half, round(here.y_m / CELL_M) - half)
        last = self._corner
        self._corner = corner
        if last is None:
            return
        for axis in (0, 1):
            shift = corner[axis] - last[axis]
            if shift:
                self._certainty = np.roll(self._certainty, -shift, axis)
                edge = slice(-shift, None) if shift > 0 else slice(0, -shift)
                self._certainty[(edge, slice(None)) if axis == 0 else (slice(None), edge)] = 0.0

    def _count(self, offsets: Points, here: Pose, step: float) -> None:
        """Change the certainty of the cells at these offsets from the robot, odometry's frame, each once."""
        corner = self._corner or (0, 0)
        east = np.rint((offsets.real + here.x_m) / CELL_M).astype(np.int64) - corner[0]
        north = np.rint((offsets.imag + here.y_m) / CELL_M).astype(np.int64) - corner[1]
        inside = (east >= 0) & (east < CELLS) & (north >= 0) & (north < CELLS)
        cells = np.unique(east[inside] * CELLS + north[inside])
        flat = self._certainty.reshape(-1)
        flat[cells] = np.clip(flat[cells] + step, 0.0, SURE)

    def _gather(self, percepts: Percepts, here: Pose) -> None:
        corner = self._corner or (0, 0)
        cells = np.argwhere(self._certainty > 0)
        east = (cells[:, 0] + corner[0]) * CELL_M - here.x_m
        north = (cells[:, 1] + corner[1]) * CELL_M - here.y_m
        robots = percepts.obstacles.at[percepts.obstacles.robots]
        remembered = (east + 1j * north) * rect(1.0, -here.heading_rad)
        self.points = np.concatenate([remembered, robots])
        self.radii_m = np.concatenate([np.zeros(len(cells)), np.full(len(robots), GRIPPER_REACH_M)])
        sure = self._certainty[cells[:, 0], cells[:, 1]] / SURE
        self.certainty = np.concatenate([sure, np.ones(len(robots))])


def _beams(percepts: Percepts) -> Points:
    """Points along every whisker short of its hit: free; robot's frame. (K,), metres."""
    ranges = np.minimum(np.asarray(percepts.ranges_m, dtype=np.float64), CELLS * CELL_M / 2)
    steps = np.arange(RADIUS_M, CELLS * CELL_M / 2, CELL_M / 2)
    angles = np.arange(len(ranges)) * (tau / len(ranges))
    free = steps[None, :] < (RADIUS_M + ranges - 1.5 * CELL_M)[:, None]
    return np.asarray((np.exp(1j * angles)[:, None] * steps[None, :])[free])
