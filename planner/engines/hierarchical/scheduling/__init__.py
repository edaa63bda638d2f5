"""The scheduling problem as arrays, its decoder and its annealing, compiled by numba."""
