"""How good and how fast the planner's plan-nets are, side by side: `python -m benchmarks.planner`."""
