"""Object recognition: turns each sensor's readings into observations for object tracking.

Infra-red identifies things by name. Hits of whiskers and bumper near a tracked thing are that thing, others become
thing_1, thing_2 ... Whiskers tell walls from things by their width.
"""

from collections.abc import Mapping
from math import cos, sin, tau

import numpy as np
from numpy.typing import NDArray

from robots.compiled import kernel
from robots.perception.tracking import Cursors, Modality, Observation
from robots.physical.body import RADIUS_M, Pose
from robots.physical.geometry import to_world
from robots.physical.sightings import Sightings

Floats = NDArray[np.float64]
Points = NDArray[np.complex128]

MEETS_M = 0.3
"""A hit this near to a tracked thing is that thing."""
NEAR_M = 1.5
"""Beyond, the whiskers' beams are too far apart to tell a thing from a wall."""
GAP_M = 0.4
"""A thing stands at least this much nearer than what the neighbouring beams hit."""
WIDE_M = 0.6
OUT_OF_REACH_M = 99.0
"""In place of infinity, since the difference of two infinities is not a number."""
HALF_THING_M = 0.1
"""From a thing's surface to its centre, about."""


def by_infra_red(sightings: Sightings, pose: Pose) -> Observation:
    """Named things in view."""
    at = sightings.in_world(pose.x_m, pose.y_m, pose.heading_rad)
    return Observation(sightings.names, Modality.INFRA_RED, at)


def by_whiskers(ranges_m: Floats, pose: Pose, cursors: Cursors) -> Observation:
    """Isolated things among the whiskers' hits.

    :param ranges_m: shape (N,), metres from the hull, beam 0 ahead, counter-clockwise, inf where nothing is met.
    """
    met: dict[str, complex] = {}
    for at in alone(ranges_m, RADIUS_M).tolist():
        there = to_world(pose, at)
        met.setdefault(_name(there, cursors, met), there)
    return Observation(tuple(met), Modality.ULTRASONIC, np.array(list(met.values()), dtype=np.complex128))


def by_touch(felt: complex, cursors: Cursors) -> Observation:
    """What the bumper has touched; world frame."""
    return Observation.of_one(_name(felt, cursors, {}), Modality.TOUCH, felt)


@kernel
def alone(ranges_m: Floats, hull_m: float) -> Points:
    """The centres of narrow groups of neighbouring hits with free space on either side.

    :param hull_m: from the robot's centre to the start of the whiskers.
    :returns: shape (G,), complex, robot's frame, metres.
    """
    count = len(ranges_m)
    found = 0
    near = np.minimum(ranges_m, OUT_OF_REACH_M)
    breaks = [beam for beam in range(count) if abs(near[beam] - near[beam - 1]) >= GAP_M]
    middles = np.empty(len(breaks), np.complex128)
    for n in range(len(breaks)):
        begin = breaks[n]
        end = breaks[n + 1] if n + 1 < len(breaks) else breaks[0] + count
        farthest = 0.0
        hits = 0j
        for beam in range(begin, end):
            away_m = hull_m + near[beam % count] + HALF_THING_M
            angle = tau * (beam % count) / count
            hits += complex(away_m * cos(angle), away_m * sin(angle))
            farthest = max(farthest, near[beam % count])
        beside = min(near[begin - 1], near[end % count])
        width_m = (farthest + hull_m) * tau * (end - begin - 1) / count
        if farthest <= NEAR_M and beside - farthest >= GAP_M and width_m <= WIDE_M:
            middles[found] = hits / (end - begin)
            found += 1
    return middles[:found]


def _name(at: complex, cursors: Cursors, taken: Mapping[str, complex]) -> str:
    """The name of the tracked thing at a place, or a new name."""
    near = cursors.nearest(at, taken)
    if near is not None and near[1] <= MEETS_M:
        return near[0]
    number = 1
    while f"thing_{number}" in cursors or f"thing_{number}" in taken:
        number += 1
    return f"thing_{number}"
