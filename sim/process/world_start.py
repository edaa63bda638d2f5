"""Whether a world goes on from its snapshot or begins afresh."""

from dataclasses import dataclass

from robots.world import WorldFile
from sim.error import NotResumable
from sim.process.keep import Keep
from sim.process.snapshot_file import SnapshotFile
from sim.world.agents import behavioural_agent
from sim.world.hub import Hub
from sim.world.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Begun:
    """A world, and why it did not go on if there might have been something to go on from."""

    simulation: Simulation
    why_afresh: str = ""


def begin(world: WorldFile, keep: Keep, file: SnapshotFile, hub: Hub, *, seed: int, jitter_m: float) -> Begun:
    """The world as it was kept; else afresh, as a seed has it.

    :raises NotResumable: if it cannot go on and is not to begin afresh; says why.
    """
    try:
        if keep.afresh:
            raise NotResumable("an operator wished it so")
        return Begun(_resumed(world, keep, file, hub))
    except NotResumable as reason:
        if keep.resume_only:
            raise
        expected = keep.run is not None or keep.file_of(world).exists()
        simulation = Simulation(world, make_agent=behavioural_agent, seed=seed, jitter_m=jitter_m, hub=hub)
        file.show_time(0.0)
        return Begun(simulation, str(reason) if expected else "")


def _resumed(world: WorldFile, keep: Keep, file: SnapshotFile, hub: Hub) -> Simulation:
    snapshot = file.read(world)
    if snapshot.run != keep.run and not keep.any_run:
        raise NotResumable("its snapshot is of a run that the record does not tell of")
    try:
        return Simulation(world, make_agent=behavioural_agent, hub=hub, snapshot=snapshot)
    except Exception as error:  # whatever does not fit it, of whatever software wrote it
        raise NotResumable(f"its snapshot does not fit: {type(error).__name__}: {error}") from error
