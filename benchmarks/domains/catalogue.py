"""The domains by name, and the sizes that are run."""

from collections.abc import Callable, Mapping, Sequence

from unified_planning.model import Problem

from benchmarks.domains import (
    blocksworld,
    depots,
    driverlog,
    elevators,
    logistics,
    rovers,
    satellite,
    zenotravel,
)
from benchmarks.domains.model import Form

DOMAINS: Mapping[str, Callable[[int, int, Form], Problem]] = {
    "blocksworld": blocksworld.problem,
    "logistics": logistics.problem,
    "rovers": rovers.problem,
    "satellite": satellite.problem,
    "depots": depots.problem,
    "zenotravel": zenotravel.problem,
    "driverlog": driverlog.problem,
    "elevators": elevators.problem,
}
"""Makes the problem of a size, a seed and a form; the same of each depends on nothing else."""

SIZES: Mapping[str, Sequence[int]] = {
    "blocksworld": (5, 9, 16),
    "logistics": (4, 8, 16),
    "rovers": (3, 6, 12),
    "satellite": (4, 8, 14),
    "depots": (3, 6, 10),
    "zenotravel": (4, 8, 14),
    "driverlog": (3, 6, 12),
    "elevators": (3, 6, 12),
}
"""Small, middling and large; what is counted, the domain's module says."""
FIRST_SEED = 1000
"""Seeds apart from those that anything was tuned with."""
