"""Object recognition: what each sensor's readings tell of which thing, as observations for object tracking.

Infra-red tells names. Whiskers and bumper tell of no name: what they meet where a thing is believed to be is that
thing, else something new, called thing_1, thing_2 ... Walls are no things: whiskers know one by its width.
"""

from cmath import rect
from collections.abc import Iterable, Iterator, Mapping
from math import inf, tau

import numpy as np
from numpy.typing import NDArray

from robots.body import RADIUS_M, Pose, Sighting
from robots.geometry import to_world
from robots.tracking.cursor import Cursor
from robots.tracking.observation import Modality, Observation

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


def by_infra_red(sightings: Iterable[Sighting], pose: Pose) -> Iterator[Observation]:
    """Named things in view."""
    for sighting in sightings:
        at = to_world(pose, rect(sighting.range_m, sighting.bearing_rad))
        yield Observation(sighting.identity, Modality.INFRA_RED, at)


def by_whiskers(
    ranges_m: NDArray[np.float64], pose: Pose, cursors: Mapping[str, Cursor]
) -> Iterator[Observation]:
    """Things that stand alone among the whiskers' hits.

    :param ranges_m: shape (N,), metres from the hull, beam 0 ahead, counter-clockwise, inf where nothing is met.
    """
    met: dict[str, complex] = {}
    for group in alone(ranges_m):
        hits = [
            rect(RADIUS_M + float(ranges_m[beam]) + HALF_THING_M, tau * beam / len(ranges_m))
            for beam in group
        ]
        at = to_world(pose, sum(hits) / len(hits))
        met.setdefault(_name(at, cursors, met), at)
    for name, at in met.items():
        yield Observation(name, Modality.ULTRASONIC, at)


def by_touch(felt: complex, cursors: Mapping[str, Cursor]) -> Observation:
    """What was bumped into, world frame."""
    return Observation(_name(felt, cursors, {}), Modality.TOUCH, felt)


def alone(ranges_m: NDArray[np.float64]) -> list[list[int]]:
    """Groups of neighbouring beams that meet something narrow, with free space on either side."""
    near = [min(range_m, OUT_OF_REACH_M) for range_m in ranges_m.tolist()]
    count = len(near)
    breaks = [beam for beam in range(count) if abs(near[beam] - near[beam - 1]) >= GAP_M]
    found = []
    for begin, end in zip(breaks, [*breaks[1:], *(one + count for one in breaks[:1])], strict=True):
        if near[begin] > NEAR_M:
            continue
        group = [beam % count for beam in range(begin, end)]
        farthest = max(near[beam] for beam in group)
        beside = min(near[begin - 1], near[end % count])
        width_m = (farthest + RADIUS_M) * tau * (len(group) - 1) / count
        if farthest <= NEAR_M and beside - farthest >= GAP_M and width_m <= WIDE_M:
            found.append(group)
    return found


def _name(at: complex, cursors: Mapping[str, Cursor], taken: Mapping[str, complex]) -> str:
    """The thing believed to be there, or a new name."""
    near = {name: abs(cursor.at - at) for name, cursor in cursors.items() if name not in taken}
    name = min(near, key=near.__getitem__, default="")
    if near.get(name, inf) <= MEETS_M:
        return name
    number = 1
    while f"thing_{number}" in cursors or f"thing_{number}" in taken:
        number += 1
    return f"thing_{number}"
