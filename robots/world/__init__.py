"""World files: the layout and the team, told to simulation and service alike, and not known to a robot's agent."""

from robots.world.file import (
    Compartment,
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
