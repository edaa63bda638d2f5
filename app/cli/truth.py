"""What is true in the simulated world itself: for the command line only, never for the service or a robot."""

from math import dist

from app.world_model.berths import berths_of
from robots.wire import SymbolicFact
from robots.world import WorldFile
from sim import Truth

NEAR_M = 1.1
"""A robot that stands at a place's approach point is near it."""


def holds(fact: SymbolicFact, world: WorldFile, truth: Truth) -> bool:
    """True if a sample is in a place or gripper, or a robot near a place; of other facts the world tells nothing."""
    if len(fact.args) != 2:
        return False
    thing, ref = fact.args
    refs = (ref, *berths_of(ref, world))
    if fact.predicate in ("in", "at") and thing in truth.samples:
        return truth.samples[thing].ref in refs
    if fact.predicate in ("near", "at") and thing in truth.robots:
        pose = truth.robots[thing]
        points = [place.at for place in world.places if place.name in refs]
        return any(dist(point, (pose.x_m, pose.y_m)) <= NEAR_M for point in points)
    return False
