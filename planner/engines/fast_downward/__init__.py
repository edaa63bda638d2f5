"""Fast Downward as a planning engine: PDDL out, separate processes, sequences back."""

from planner.engines.fast_downward.fast_downward_engine import FastDownwardEngine
from planner.engines.fast_downward.process import find_programs

__all__ = ["FastDownwardEngine", "find_programs"]
