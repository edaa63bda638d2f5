"""Proven lower bounds of the makespan, for every plan-net of a problem; any engine may ask for them."""

from planner.bounds.bound import lower_bound_s
from planner.bounds.paths import warm_up

__all__ = ["lower_bound_s", "warm_up"]
