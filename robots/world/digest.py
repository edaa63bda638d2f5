"""Tells whether two world files describe the same world."""

from hashlib import sha256
from json import dumps

from robots.world.file import WorldFile


def digest_of(world: WorldFile) -> str:
    """A digest that is equal for two files of the same world; omitted defaults do not matter."""
    content = world.model_dump(mode="json", exclude_defaults=True)
    return sha256(dumps(content, sort_keys=True).encode()).hexdigest()
