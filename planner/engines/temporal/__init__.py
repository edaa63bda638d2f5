"""Engines that schedule durative actions themselves: LPG-td and Aries, both optional, run as separate processes."""

from planner.engines.temporal.aries import Aries
from planner.engines.temporal.lpg import Lpg
from planner.engines.temporal.temporal_engine import Solver, TemporalEngine

__all__ = ["Aries", "Lpg", "Solver", "TemporalEngine"]
