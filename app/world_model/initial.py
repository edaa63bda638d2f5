"""The initial facts of a world, from its world file (MACTA §4: the world model describes the initial state)."""

from collections.abc import Iterator
from math import dist

from app.vocabulary import Vocabulary, planner_fact
from app.world_model.beliefs import (
    CAN,
    EMPTY,
    GRIPPER,
    IN,
    IN_AREA,
    NEAR,
    OBJECT_POSITION,
    REACHES,
    ROBOT_ATTRIBUTE,
    ROBOT_POSITION,
    Facts,
    derived,
    revised,
    spot_of,
)
from planner.fact import Fact
from robots.wire import SymbolicFact
from robots.world import RobotSpec, WorldFile

ROBOT, OBJECT, LOCATION, AREA = "robot", "object", "location", "area"
HOME_RADIUS_M = 1.5
"""A robot that starts no farther from its home's beacon than this is believed to be near home (our choice)."""


def objects_of(world: WorldFile) -> dict[str, str]:
    """Every object of the world and its type; a robot's open-floor spot is a location."""
    named = {place.name: LOCATION for place in world.locations}
    named |= {sample.name: OBJECT for sample in world.samples}
    for robot in world.robots:
        named |= {robot.name: ROBOT, spot_of(robot.name): LOCATION, world.area_of(robot).name: AREA}
    return named


def initial_facts(world: WorldFile, vocabulary: Vocabulary) -> Facts:
    """The facts that hold at the start, in the planner's form.

    The file's extra facts win over what the layout says of the same robot or object.

    :raises planner.KnowledgeBaseError: if an extra fact is not of the vocabulary.
    """
    layout = {fact for robot in world.robots for fact in _of_robot(world, robot)}
    layout |= {Fact(OBJECT_POSITION, (sample.name, IN, sample.at)) for sample in world.samples}
    objects = objects_of(world)
    extra = [
        planner_fact(SymbolicFact(predicate=f.predicate, args=f.args), vocabulary, objects) for f in world.facts
    ]
    return revised(world, derived(world, frozenset(layout)), extra)


def initial_spots(world: WorldFile) -> dict[str, tuple[float, float]]:
    """Where the robots that start away from any home stand: location → (x, y) in metres."""
    return {
        spot_of(robot.name): robot.start[:2] for robot in world.robots if not _starts_at_home(world, robot)
    }


def _of_robot(world: WorldFile, robot: RobotSpec) -> Iterator[Fact]:
    home = robot.home if robot.home and _starts_at_home(world, robot) else spot_of(robot.name)
    yield Fact(ROBOT_POSITION, (robot.name, NEAR, home))
    yield Fact(ROBOT_ATTRIBUTE, (robot.name, GRIPPER, EMPTY))
    yield Fact(IN_AREA, (robot.name, world.area_of(robot).name))
    for place in world.reach_of(robot):
        yield Fact(REACHES, (robot.name, place.name))
    for tag in robot.repertoire:
        yield Fact(CAN, (robot.name, tag))


def _starts_at_home(world: WorldFile, robot: RobotSpec) -> bool:
    return robot.home is not None and dist(robot.start[:2], world.location(robot.home).at) <= HOME_RADIUS_M
