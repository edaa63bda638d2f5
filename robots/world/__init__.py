"""World files: layout and team. Read by the simulation and the service; a robot's own software never sees them."""

from robots.world.digest import digest_of
from robots.world.edition import Edition
from robots.world.file import BIDS, CLEARANCE, DELEGATION, PERSONS, WorldFile
from robots.world.generate import StoreShape, StoreShapeError, generate_world, store_shape, world_yaml
from robots.world.load import WorldFileError, load_world, named_worlds, read_world, shipped_worlds
from robots.world.parts import (
    Compartment,
    Delivery,
    Location,
    Obstacle,
    Opening,
    RobotSpec,
    RoleSpec,
    Sample,
    Slope,
    Wall,
    WorldFact,
    WorldNumber,
    Zone,
    ZoneRule,
)
from robots.world.peripherals import PERIPHERAL_TAGS, Peripheral, PeripheralKind
from robots.world.radio import Contact, LinkSpec, Outage

__all__ = [
    "BIDS",
    "CLEARANCE",
    "DELEGATION",
    "PERIPHERAL_TAGS",
    "PERSONS",
    "Compartment",
    "Contact",
    "Delivery",
    "Edition",
    "LinkSpec",
    "Location",
    "Obstacle",
    "Opening",
    "Outage",
    "Peripheral",
    "PeripheralKind",
    "RobotSpec",
    "RoleSpec",
    "Sample",
    "Slope",
    "StoreShape",
    "StoreShapeError",
    "Wall",
    "WorldFact",
    "WorldFile",
    "WorldFileError",
    "WorldNumber",
    "Zone",
    "ZoneRule",
    "digest_of",
    "generate_world",
    "load_world",
    "named_worlds",
    "read_world",
    "shipped_worlds",
    "store_shape",
    "world_yaml",
]
