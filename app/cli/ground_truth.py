"""The simulation's ground truth, for the command line; the service and the robots never read it."""

from math import dist
from pathlib import Path

from app.domain.world_model.berths import berths_of
from robots.wire import SymbolicFact
from robots.world import WorldFile
from sim import Truth

NEAR_M = 1.1
"""A robot that stands at a place's approach point is near it."""


def holds(fact: SymbolicFact, world: WorldFile, truth: Truth) -> bool | None:
    """Whether a sample is in its place or gripper, or a robot near its place; None for all other facts."""
    if len(fact.args) != 2:
        return None
    thing, ref = fact.args
    refs = (ref, *berths_of(ref, world))
    if fact.predicate in ("in", "at") and thing in truth.samples:
        return truth.samples[thing].ref in refs
    if fact.predicate in ("near", "at") and thing in truth.robots:
        return any(is_near(truth, thing, place, world) for place in refs)
    return None


def is_near(truth: Truth, robot: str, place: str, world: WorldFile) -> bool:
    """Whether a robot stands at a place's approach point."""
    pose = truth.robots[robot]
    points = [one.at for one in world.places if one.name == place]
    return any(dist(point, (pose.x_m, pose.y_m)) <= NEAR_M for point in points)


def snapshot_truth(data: Path, world: WorldFile) -> Truth:
    """The ground truth of a world by its last snapshot in the data folder."""
    # NOTE: imported here, for they load the physics.
    from sim.snapshot import WorldSnapshot
    from sim.world.agents import behavioural_agent
    from sim.world.simulation import Simulation

    snapshot = WorldSnapshot.model_validate_json((data / "worlds" / f"{world.name}.json").read_bytes())
    simulation = Simulation(world, make_agent=behavioural_agent, snapshot=snapshot)
    try:
        return simulation.truth()
    finally:
        simulation.close()
