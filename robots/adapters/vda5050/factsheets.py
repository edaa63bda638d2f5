"""A vehicle's factsheet as a robot's, and the other way round. Pure."""

import re
from collections.abc import Mapping, Set
from math import degrees

from robots.adapters.packet_forms import PacketForm
from robots.adapters.vda5050.frame import Pose
from robots.adapters.vda5050.messages import VehicleFactsheet
from robots.adapters.vda5050.settings import PacketSettings, Settings
from robots.adapters.vda5050.topics import VehicleId
from robots.wire import Factsheet

FASTEST_M_S = 2.0
FASTEST_RAD_S = 6.0
"""No robot of a world is faster; a vehicle that can be is planned with these."""
NODE = "NODE"


def robot_name(vehicle: VehicleId, settings: Settings) -> str:
    """What a vehicle is called in the world: by its settings, else its serial number as a name."""
    named = settings.of(vehicle).robot
    if named is not None:
        return named
    name = re.sub(r"[^a-z0-9]+", "_", vehicle.serial_number.lower()).strip("_")
    return name[:64] if name[:1].isalpha() else f"vehicle_{name}"[:64]


def repertoire(sheet: VehicleFactsheet | None, vehicle: VehicleId, settings: Settings) -> tuple[str, ...]:
    """The packets that a vehicle can carry out: by its settings, else those whose actions it supports at nodes."""
    stated = settings.of(vehicle).repertoire
    if stated is not None:
        return stated
    known = sheet.protocol_features.mobile_robot_actions if sheet is not None else ()
    supported = {action.action_type for action in known if NODE in action.action_scopes}
    rules = settings.all_packets.items()
    return tuple(tag for tag, rule in rules if rule.announced and _needs(rule) <= supported)


def _needs(rule: PacketSettings) -> Set[str]:
    return {*rule.needs, *(action.type for action in rule.actions)}


def packet_forms(tags: tuple[str, ...], settings: Settings) -> Mapping[str, PacketForm]:
    """The forms of the packets that a vehicle takes."""
    places = frozenset(settings.places)
    forms = {}
    for tag in tags:
        rule = settings.all_packets.get(tag, PacketSettings())
        choices = {} if rule.drive is None else {rule.drive: places}
        forms[tag] = PacketForm(choices=choices)
    return forms


def robot_factsheet(
    sheet: VehicleFactsheet | None, vehicle: VehicleId, pose: Pose, settings: Settings
) -> Factsheet:
    """The factsheet of the robot that a vehicle is. It senses nothing of other robots' work (`senses`).

    :param pose: where it stands in the world.
    """
    own = settings.of(vehicle)
    frame = settings.frame_of(vehicle)
    physical = sheet.physical_parameters if sheet is not None else None
    speed = physical.maximum_speed / frame.scale if physical is not None else 0.0
    turn = (physical.maximum_angular_speed or 0.0) if physical is not None else 0.0
    said = {
        "repertoire": repertoire(sheet, vehicle, settings),
        "speed_m_s": min(FASTEST_M_S, own.speed_m_s or speed or settings.speed_m_s),
        "turn_rad_s": min(FASTEST_RAD_S, own.turn_rad_s or turn or settings.turn_rad_s),
        "compartment": own.compartment,
        "aisle": own.aisle,
        "home": own.home,
        "start": (round(pose[0], 3), round(pose[1], 3), round(degrees(pose[2]), 1)),
        "senses": (),
    }
    return Factsheet.model_validate(said)
