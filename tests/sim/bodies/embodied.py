"""Worlds whose robots are given other bodies."""

from typing import Any

from robots.world import WorldFile


def embodied(world: WorldFile, *bodies: Any) -> WorldFile:
    """The world with these bodies, by the order of its robots; the last one is also for those that are left."""
    file = world.model_dump()
    for number, robot in enumerate(file["robots"]):
        robot["body"] = bodies[min(number, len(bodies) - 1)]
    return WorldFile.model_validate(file)
