"""Errors of the simulation package."""


class SimulationError(RuntimeError):
    """Raised when a simulated world cannot be built, or its process is gone or does not answer."""
