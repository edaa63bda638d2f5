"""Errors of the simulation package."""


class SimulationError(RuntimeError):
    """Raised when a simulated world cannot be built, or its process is gone or does not answer."""


class NotResumable(SimulationError):
    """Raised when a world cannot go on from a snapshot; the message says why."""
