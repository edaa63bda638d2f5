"""PyBullet worlds: they implement the robots' bodies and sensors. One process a world (`SimulationProcess`).

Only the composition root and the command line may import from here. `sim.world.simulation.Simulation` is the same world
inside the caller's process, for tests and benchmarks; it loads PyBullet, this package alone does not.
"""

from sim.error import NotResumable, SimulationError
from sim.process.keep import Keep
from sim.process.process import SimulationProcess
from sim.process.supervisor import LastingWorld
from sim.truth import SampleTruth, Truth

__all__ = [
    "Keep",
    "LastingWorld",
    "NotResumable",
    "SampleTruth",
    "SimulationError",
    "SimulationProcess",
    "Truth",
]
