"""Costs of the simulation beside a bare loop of its physics engine."""

from collections.abc import Iterator

from benchmarks import stack
from benchmarks.costs.table import Row

ROBOTS = {4: ("3.7", None, ""), 16: ("2.8", None, ""), 64: ("3.8", 4.0, "1.5"), 256: ("5.9", 1.0, "0.2")}
"""By number: the ratio before, the speed that is wanted, and the speed before."""


def simulation(runs: int) -> Iterator[Row]:
    """The whole simulation beside a loop that only steps PyBullet and casts the rays."""
    for robots, (before, speed, speed_before) in ROBOTS.items():
        found = [stack.figures(robots) for _ in range(runs)]
        yield Row(
            what=f"simulation beside a bare loop with rays, {robots} robots",
            unit="ratio",
            values=[one.whole / one.rays for one in found],
            target=2,
            before=before,
        )
        yield Row(
            what=f"simulation, {robots} robots",
            unit="× real time",
            values=[1 / one.path for one in found],
            target=speed,
            before=speed_before,
            more_is_better=True,
        )
