"""What a robot's factsheet says, beside a world: the robot that it would add, or what it would change."""

from typing import Any

from pydantic import ValidationError

from app.domain.errors import Invalid
from app.domain.world_model.beliefs import CAN, HAS_BODY, HAS_SENSOR, IN_AREA, REACHES, Facts
from app.domain.world_model.edits import AddRobot, ChangeRobot
from app.domain.world_model.initial import facts_of_robot
from planner import KnowledgeBase
from robots.wire import Factsheet
from robots.world import RobotSpec, WorldFile

RESERVED = frozenset({"fleet", "service"})
"""Names of others on the link."""
SAID = frozenset({CAN, HAS_BODY, HAS_SENSOR, IN_AREA, REACHES})
"""Predicates of what a factsheet says of its robot."""


def facts_said_by(robot: RobotSpec, world: WorldFile, knowledge_base: KnowledgeBase) -> Facts:
    """The facts that rest on the factsheet of one of the world's robots."""
    facts = facts_of_robot(world, robot, knowledge_base)
    return frozenset(fact for fact in facts if fact.predicate in SAID)


def addition(name: str, sheet: Factsheet, world: WorldFile) -> AddRobot:
    """The edit that adds the robot to a world that does not have it.

    :raises Invalid: if the factsheet describes no robot of this world.
    """
    if name in RESERVED:
        raise Invalid(f"no robot may be named {name}", code="name-reserved", thing=name)
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
    return AddRobot(robot=_robot({"name": name, "external": True} | said))


def difference(sheet: Factsheet, robot: RobotSpec) -> ChangeRobot | None:
    """The edit that makes the world's robot what its factsheet says; None if it is so already.

    What the factsheet leaves out of area and home stays.
    :raises Invalid: if the factsheet describes no robot.
    """
    said = _abilities(sheet)
    if sheet.compartment is not None:
        said |= {"compartment": sheet.compartment, "aisle": sheet.aisle}
    elif sheet.aisle is not None:
        said |= {"aisle": sheet.aisle}
    if sheet.home is not None:
        said |= {"home": sheet.home}
    if sheet.senses is not None and set(sheet.senses) == set(robot.senses or ()) and robot.senses is not None:
        del said["senses"]
    if set(sheet.repertoire) == set(robot.repertoire):
        del said["repertoire"]
    now = _robot(dict(robot) | said)
    values = {field: getattr(now, field) for field in said if getattr(now, field) != getattr(robot, field)}
    if values.keys() & {"compartment", "aisle"} and sheet.start is not None:
        values["start"] = sheet.start
    return ChangeRobot(name=robot.name, **values) if values else None


def _abilities(sheet: Factsheet) -> dict[str, Any]:
    senses = {} if sheet.senses is None else {"senses": sheet.senses}
    return senses | {
        "body": sheet.body,
        "sensors": sheet.sensors,
        "repertoire": sheet.repertoire,
        "speed_m_s": sheet.speed_m_s,
        "turn_rad_s": sheet.turn_rad_s,
    }


def _robot(values: dict[str, Any]) -> RobotSpec:
    try:
        return RobotSpec.model_validate(values)
    except ValidationError as error:
        fault = error.errors()[0]
        where = ".".join(map(str, fault["loc"]))
        words = fault["msg"].removeprefix("Value error, ")
        raise Invalid(
            f"the factsheet of {values['name']}: {where + ': ' if where else ''}{words}",
            code="factsheet-does-not-fit",
        ) from error
