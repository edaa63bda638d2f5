"""PyBullet worlds: they implement the robots' bodies and sensors.

Rooms, top imports down: `trials` (experiments), `process` (a world in a process of its own), `world` (a world in the
caller's process), `bodies`, `physics`. Only the composition root and the command line may import from here. This module
does not load PyBullet; `sim.world.simulation` does.
"""

from sim.error import NotResumable, SimulationError
from sim.process.process import SimulationProcess
from sim.process.snapshot_file import SnapshotSettings
from sim.process.supervisor import SupervisedWorld
from sim.truth import SampleTruth, Truth

__all__ = [
    "NotResumable",
    "SampleTruth",
    "SimulationError",
    "SimulationProcess",
    "SnapshotSettings",
    "SupervisedWorld",
    "Truth",
]
