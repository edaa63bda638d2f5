"""The editions of a world: its file, and what changes of it have made of that while the world runs."""

from dataclasses import dataclass

from robots.world.file import WorldFile


@dataclass(frozen=True, slots=True)
class Edition:
    """A world as it is after `number` changes; 0 is its file."""

    number: int
    world: WorldFile
