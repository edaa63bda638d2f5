"""What a robot's factsheet says, beside a world: the robot that it would add, or what it would change."""

from typing import Any, TypeVar

from pydantic import ValidationError

from app.domain.errors import Invalid
from app.domain.world_model.beliefs import CAN, HAS_BODY, HAS_SENSOR, IN_AREA, REACHES, Facts
from app.domain.world_model.edits import AddPeripheral, AddRobot, ChangePeripheral, ChangeRobot
from app.domain.world_model.initial import facts_of_robot
from planner import KnowledgeBase
from robots.wire import Factsheet
from robots.world import Peripheral, RobotSpec, WorldFile

RESERVED = frozenset({"fleet", "service"})
"""Names of others on the link."""
SAID = frozenset({CAN, HAS_BODY, HAS_SENSOR, IN_AREA, REACHES})
"""Predicates of what a factsheet says of its robot."""


Part = TypeVar("Part", RobotSpec, Peripheral)


def facts_said_by(robot: RobotSpec | Peripheral, world: WorldFile, knowledge_base: KnowledgeBase) -> Facts:
    """The facts that rest on the factsheet of one of the world's robots, doors, hatches or lifts."""
    if isinstance(robot, Peripheral):
        return frozenset()
    facts = facts_of_robot(world, robot, knowledge_base)
    return frozenset(fact for fact in facts if fact.predicate in SAID)


def addition(name: str, sheet: Factsheet, world: WorldFile) -> AddRobot | AddPeripheral:
    """The edit that adds the robot, door, hatch or lift to a world that does not have it.

    :raises Invalid: if the factsheet describes no robot of this world.
    """
    if name in RESERVED:
        raise Invalid(f"no robot may be named {name}", code="name-reserved", thing=name)
    if sheet.peripheral is not None:
        return AddPeripheral(peripheral=_peripheral(name, sheet))
    if sheet.start is None:
        raise Invalid(
            f"the factsheet of {name} does not say where it stands (start)", code="factsheet-incomplete"
        )
    point = sheet.start[:2]
    compartments = [one.name for one in world.compartments if one.contains(point)]
    if sheet.compartment is None and not compartments:
        raise Invalid(
            f"{name} says that it stands at ({point[0]:g}, {point[1]:g}), in no compartment of {world.name}",
            code="factsheet-does-not-fit",
            choices=[one.name for one in world.compartments],
        )
    area = {"compartment": sheet.compartment or compartments[0], "aisle": sheet.aisle}
    said = _abilities(sheet) | area | {"home": sheet.home, "start": sheet.start}
    return AddRobot(robot=_part(RobotSpec, {"name": name, "external": True} | said))


def difference(sheet: Factsheet, robot: RobotSpec | Peripheral) -> ChangeRobot | ChangePeripheral | None:
    """The edit that makes the world's robot, door, hatch or lift what its factsheet says; None if it is so already.

    What the factsheet leaves out of area and home stays.
    :raises Invalid: if the factsheet describes no robot, or no peripheral where the world has one.
    """
    if isinstance(robot, Peripheral) or sheet.peripheral is not None:
        return _other_peripheral(sheet, robot)
    said = _abilities(sheet)
    if sheet.compartment is not None:
        said |= {"compartment": sheet.compartment, "aisle": sheet.aisle}
    elif sheet.aisle is not None:
        said |= {"aisle": sheet.aisle}
    if sheet.home is not None:
        said |= {"home": sheet.home}
    if sheet.senses is not None and set(sheet.senses) == set(robot.senses or ()) and robot.senses is not None:
        del said["senses"]
    if sheet.speaks is not None and robot.speaks is not None and set(sheet.speaks) == set(robot.speaks):
        del said["speaks"]
    if set(sheet.repertoire) == set(robot.repertoire):
        del said["repertoire"]
    now = _part(RobotSpec, dict(robot) | said)
    values = {field: getattr(now, field) for field in said if getattr(now, field) != getattr(robot, field)}
    if "body" in values and not robot.external:
        raise Invalid(
            f"{robot.name} is simulated with its body, {robot.body.kind}; an operator moves its mind by :embody",
            code="body-is-simulated",
            thing=robot.name,
        )
    if values.keys() & {"compartment", "aisle"} and sheet.start is not None:
        values["start"] = sheet.start
    return ChangeRobot(name=robot.name, **values) if values else None


def _other_peripheral(sheet: Factsheet, known: RobotSpec | Peripheral) -> ChangePeripheral | None:
    if not isinstance(known, Peripheral) or sheet.peripheral is None:
        kind = known.kind if isinstance(known, Peripheral) else "robot"
        said = "none" if isinstance(known, Peripheral) else "one"
        raise Invalid(
            f"{known.name} is a {kind} of the world, and its factsheet describes {said} (peripheral)",
            code="factsheet-does-not-fit",
            thing=known.name,
        )
    now = _peripheral(known.name, sheet)
    return None if now == known else ChangePeripheral(peripheral=now)


def _peripheral(name: str, sheet: Factsheet) -> Peripheral:
    one = _part(Peripheral, {**(sheet.peripheral or {}), "name": name, "external": True})
    if set(sheet.repertoire) != set(one.repertoire):
        raise Invalid(
            f"the factsheet of {name}: the repertoire of a {one.kind} is {', '.join(one.repertoire)}",
            code="factsheet-does-not-fit",
            choices=one.repertoire,
            thing=name,
        )
    return one


def _abilities(sheet: Factsheet) -> dict[str, Any]:
    senses = {} if sheet.senses is None else {"senses": sheet.senses}
    speaks = {} if sheet.speaks is None else {"speaks": sheet.speaks}
    return {
        **senses,
        **speaks,
        "body": sheet.body,
        "sensors": sheet.sensors,
        "repertoire": sheet.repertoire,
        "speed_m_s": sheet.speed_m_s,
        "turn_rad_s": sheet.turn_rad_s,
    }


def _part(kind: type[Part], values: dict[str, Any]) -> Part:
    try:
        return kind.model_validate(values)
    except ValidationError as error:
        fault = error.errors()[0]
        where = ".".join(map(str, fault["loc"]))
        words = fault["msg"].removeprefix("Value error, ")
        raise Invalid(
            f"the factsheet of {values['name']}: {where + ': ' if where else ''}{words}",
            code="factsheet-does-not-fit",
        ) from error
