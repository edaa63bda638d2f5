"""The delete relaxation: what could hold if nothing were ever deleted. What it does not reach, no plan does.

Operators become rules over literals (`rules`), rules become a network of joins that is run to its fixed point
(`network`); `reachability` asks it about planning problems. Lifted: nothing is ground but what is reached.
"""

from planner.relaxation.closed_zones import closed_zones, without_ways_into
from planner.relaxation.reachability import Relaxation, is_relaxed_reachable, unreachable_goals

__all__ = [
    "Relaxation",
    "closed_zones",
    "is_relaxed_reachable",
    "unreachable_goals",
    "without_ways_into",
]
