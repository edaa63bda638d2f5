"""Engines that schedule durative actions themselves: LPG-td and Aries, both optional, run as separate processes."""

from planner.temporal.aries import Aries
from planner.temporal.engine import Solver, TemporalEngine
from planner.temporal.lpg import Lpg

__all__ = ["Aries", "Lpg", "Solver", "TemporalEngine"]
