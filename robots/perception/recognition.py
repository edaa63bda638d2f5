"""Object recognition: what each sensor's readings tell of which thing, as observations for object tracking.

Infra-red tells names. Whiskers and bumper tell of no name: what they meet where a thing is believed to be is that
thing, else something new, called thing_1, thing_2 ... Walls are no things: whiskers know one by its width.
"""

from collections.abc import Mapping
from math import cos, sin, tau

import numba
import numpy as np
from numpy.typing import NDArray

from robots.perception.tracking import Cursors, Modality, Observation
from robots.physical.body import RADIUS_M, Pose
from robots.physical.geometry import to_world
from robots.physical.sightings import Sightings

Floats = NDArray[np.float64]
Points = NDArray[np.complex128]

MEETS_M = 0.3
"""Something met this near to where a thing is believed to be is that thing."""
NEAR_M = 1.5
"""Farther off a whisker's beams lie too far apart to tell a thing from a wall."""
GAP_M = 0.4
"""What stands this much nearer than what is seen beside it stands alone."""
WIDE_M = 0.6
OUT_OF_REACH_M = 99.0
"""Stands for what meets nothing: the difference of two infinities is no number."""
HALF_THING_M = 0.1
"""A thing's surface is met, its middle lies about this far behind."""


def by_infra_red(sightings: Sightings, pose: Pose) -> Observation:
    """Named things in view."""
    at = sightings.in_world(pose.x_m, pose.y_m, pose.heading_rad)
    return Observation(sightings.names, Modality.INFRA_RED, at)


def by_whiskers(ranges_m: Floats, pose: Pose, cursors: Cursors) -> Observation:
    """Things that stand alone among the whiskers' hits.

    :param ranges_m: shape (N,), metres from the hull, beam 0 ahead, counter-clockwise, inf where nothing is met.
    """
    met: dict[str, complex] = {}
    for at in alone(ranges_m, RADIUS_M).tolist():
        there = to_world(pose, at)
        met.setdefault(_name(there, cursors, met), there)
    return Observation(tuple(met), Modality.ULTRASONIC, np.array(list(met.values()), dtype=np.complex128))


def by_touch(felt: complex, cursors: Cursors) -> Observation:
    """What was bumped into, world frame."""
    return Observation.of_one(_name(felt, cursors, {}), Modality.TOUCH, felt)


@numba.njit(cache=True)
def alone(ranges_m: Floats, hull_m: float) -> Points:
    """The middles of what is met by neighbouring beams and is narrow, with free space on either side.

    :param hull_m: from the robot's middle to where whiskers begin.
    :returns: shape (G,), complex, robot's frame, metres.
    """
    count, found = len(ranges_m), 0
    near = np.minimum(ranges_m, OUT_OF_REACH_M)
    breaks = [beam for beam in range(count) if abs(near[beam] - near[beam - 1]) >= GAP_M]
    middles = np.empty(len(breaks), np.complex128)
    for n in range(len(breaks)):
        begin = breaks[n]
        end = breaks[n + 1] if n + 1 < len(breaks) else breaks[0] + count
        farthest, hits = 0.0, 0j
        for beam in range(begin, end):
            away_m, angle = hull_m + ranges_m[beam % count] + HALF_THING_M, tau * (beam % count) / count
            hits += complex(away_m * cos(angle), away_m * sin(angle))
            farthest = max(farthest, near[beam % count])
        beside = min(near[begin - 1], near[end % count])
        width_m = (farthest + hull_m) * tau * (end - begin - 1) / count
        if farthest <= NEAR_M and beside - farthest >= GAP_M and width_m <= WIDE_M:
            middles[found] = hits / (end - begin)
            found += 1
    return middles[:found]


def _name(at: complex, cursors: Cursors, taken: Mapping[str, complex]) -> str:
    """The thing believed to be there, or a new name."""
    near = cursors.nearest(at, taken)
    if near is not None and near[1] <= MEETS_M:
        return near[0]
    number = 1
    while f"thing_{number}" in cursors or f"thing_{number}" in taken:
        number += 1
    return f"thing_{number}"
