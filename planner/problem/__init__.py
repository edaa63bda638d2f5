"""The planning problem, the interface of planning engines, and what follows from a problem without planning."""
