"""Fast Downward as a planning engine: PDDL out, separate processes, sequences back."""

from planner.fast_downward.engine import FastDownwardEngine

__all__ = ["FastDownwardEngine"]
