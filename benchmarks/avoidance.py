"""MOVE_TO across cluttered rooms, by each method of obstacle avoidance: arrivals, contacts, time, distance.

uv run python -m benchmarks.avoidance [SEEDS] [BOXES]
"""

import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import dist

import numpy as np

from benchmarks.trial import Box, Trial, packet, room
from robots.wire import ScriptState

METHODS = ("patterns", "vfh_plus", "dynamic_window")
SIZE_M, START, GOAL = (8.0, 6.0), (0.9, 3.0, 0.0), (7.1, 3.0)
PASSAGE_M = 0.9
"""Least width of a passage between boxes; the rover is 0.44 m wide."""
LIMIT_S = 90.0


def clutter(seed: int, count: int) -> list[Box]:
    """Random boxes; one that leaves too narrow a passage is drawn again, a limited number of times."""
    rng = np.random.default_rng(seed)
    boxes: list[Box] = []
    for _ in range(50 * count):
        width, height = rng.uniform(0.2, 1.2, 2)
        west, south = rng.uniform(PASSAGE_M, SIZE_M[0] - 2), rng.uniform(0, SIZE_M[1] - height)
        box = (west, south, west + width, south + height)
        if len(boxes) < count and _fits(box, boxes):
            boxes.append(box)
    return boxes


def _fits(box: Box, boxes: list[Box]) -> bool:
    _west, south, east, north = box
    clear = [gap_m(box, (*point, *point)) > PASSAGE_M for point in (START[:2], GOAL)]
    walls = [0.0 < gap < PASSAGE_M for gap in (south, SIZE_M[1] - north, SIZE_M[0] - east)]
    return all(clear) and not any(walls) and all(gap_m(box, other) >= PASSAGE_M for other in boxes)


def gap_m(one: Box, other: Box) -> float:
    across = max(one[0] - other[2], other[0] - one[2], 0.0)
    along = max(one[1] - other[3], other[1] - one[3], 0.0)
    return dist((0, 0), (across, along))


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """One drive across one room."""

    arrived: bool
    touched: bool
    took_s: float
    way_m: float
    cpu_s: float


def drive(method: str, seed: int, boxes: int) -> Drive:
    """One room by one method."""
    world = room(size=SIZE_M, start=START, boxes=clutter(seed, boxes))
    order = packet("MOVE_TO", x=GOAL[0], y=GOAL[1], avoid=method, timeout_s=LIMIT_S)
    begun_s = time.process_time()
    trial = Trial(world, order, seed=seed, jitter_m=0.3).run(limit_s=LIMIT_S + 5)
    trial.simulation.close()
    assert trial.ended is not None
    return Drive(
        arrived=trial.ended.state is ScriptState.FINISHED,
        touched=trial.touched,
        took_s=trial.ended.at_s,
        way_m=trial.driven_m,
        cpu_s=time.process_time() - begun_s,
    )


def rows(seeds: int, boxes: int) -> Iterator[str]:
    """The table, a line a method."""
    yield f"{seeds} rooms of {SIZE_M[0]:g} x {SIZE_M[1]:g} m, up to {boxes} boxes, passages of {PASSAGE_M} m and more"
    yield f"{'':16}{'arrived':>9}{'untouched':>11}{'time s':>16}{'way m':>8}{'CPU ms a world s':>18}"
    for method in METHODS:
        drives = [drive(method, seed, boxes) for seed in range(seeds)]
        there = [one for one in drives if one.arrived]
        times = sorted(one.took_s for one in there) or [float("nan")]
        spread = f"{statistics.median(times):.1f} ({times[0]:.0f}-{times[-1]:.0f})"
        way_m = statistics.median([one.way_m for one in there] or [float("nan")])
        cpu = 1000 * sum(one.cpu_s for one in drives) / sum(one.took_s for one in drives)
        untouched = sum(not one.touched for one in drives)
        yield f"{method:16}{len(there):>6}/{seeds:<2}{untouched:>8}/{seeds:<2}{spread:>16}{way_m:>8.1f}{cpu:>18.1f}"


def main() -> None:
    """Print the table."""
    given = [int(word) for word in sys.argv[1:]]
    for line in rows(*(given + [30, 8][len(given) :])):
        print(line, flush=True)


if __name__ == "__main__":
    main()
