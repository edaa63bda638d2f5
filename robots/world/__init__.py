"""World files: the layout and the team that simulation and service are both told about. Not known to a robot's agent."""

from robots.world.file import (
    Compartment,
    LinkProperties,
    Location,
    Opening,
    RobotSpec,
    Sample,
    Wall,
    WorldFact,
    WorldFile,
)
from robots.world.load import WorldFileError, load_world, named_worlds

__all__ = [
    "Compartment",
    "LinkProperties",
    "Location",
    "Opening",
    "RobotSpec",
    "Sample",
    "Wall",
    "WorldFact",
    "WorldFile",
    "WorldFileError",
    "load_world",
    "named_worlds",
]
