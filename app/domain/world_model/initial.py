"""The initial facts of a world, from its world file (MACTA §4, fig. 4: the world model)."""

from collections.abc import Iterator
from math import dist

from app.domain.errors import Invalid
from app.domain.world_model.beliefs import (
    CAN,
    EMPTY,
    GRIPPER,
    HAS_BODY,
    HAS_SENSOR,
    IN,
    IN_AREA,
    IN_ZONE,
    NEAR,
    OBJECT_POSITION,
    OWN_SPOT,
    REACHES,
    ROBOT_ATTRIBUTE,
    ROBOT_POSITION,
    SOLID,
    VACANT,
    ZONE_CLEAR,
    Facts,
    contradiction,
    revise_beliefs,
    spot_of,
)
from app.domain.world_model.berths import resolve_statements
from app.domain.world_model.passages import facts_of_peripherals
from app.domain.world_model.problem import LONG_OBJECT, has_peripherals, objects_of
from app.domain.world_model.senses import refuse_unknown_senses
from app.domain.world_model.vocabulary import stated_fact, symbolic_all
from app.domain.world_model.zones import places_in_zones
from planner import Fact, KnowledgeBase
from robots.world import RobotSpec, WorldFile, ZoneRule

HOME_RADIUS_M = 1.5
"""A robot that starts no farther from the beacon of its home or of a charger is believed to be near it (our choice)."""


def initial_facts(world: WorldFile, knowledge_base: KnowledgeBase) -> Facts:
    """The facts that hold at the start, in the planner's form.

    The file's extra facts override those that the layout implies for the same robot or object.

    :raises planner.KnowledgeBaseError: if an extra fact is not in the vocabulary.
    :raises Invalid: if an extra fact must name a berth and does not, or contradicts another one.
    """
    layout = {fact for robot in world.robots for fact in facts_of_robot(world, robot, knowledge_base)}
    if _is_used(OWN_SPOT, world, knowledge_base):
        layout |= {Fact(OWN_SPOT, (robot.name, spot_of(robot.name))) for robot in world.robots}
    if _is_used(SOLID, world, knowledge_base):
        layout |= {Fact(SOLID, (robot.name,)) for robot in world.robots if robot.body.is_solid}
    layout |= {Fact(VACANT, (place.name,)) for place in world.places if place.capacity > 0}
    layout |= {Fact(OBJECT_POSITION, (sample, IN, place)) for sample, place in world.initial_places.items()}
    if ZONE_CLEAR in knowledge_base.predicates:
        layout |= {Fact(ZONE_CLEAR, (zone.name,)) for zone in world.zones_of(ZoneRule.ONE_ROBOT)}
        layout |= {Fact(IN_ZONE, args) for args in places_in_zones(world)}
        layout |= {Fact(ZONE_CLEAR, (one.passage,)) for one in world.peripherals if one.passage}
    if has_peripherals(knowledge_base):
        layout |= set(facts_of_peripherals(world))
    objects = objects_of(world)
    stated = [(fact.predicate, fact.args, True) for fact in world.facts]
    extra = [
        stated_fact(predicate, args, knowledge_base, objects)
        for predicate, args, _ in resolve_statements(stated, world, frozenset(layout))
    ]
    if (pair := contradiction(frozenset(layout), extra)) is not None:
        one, other = symbolic_all(pair, knowledge_base)
        raise Invalid(f"{one} and {other} cannot both be true", code="contradicting-facts")
    return revise_beliefs(frozenset(layout), extra)


def _is_used(predicate: str, world: WorldFile, knowledge_base: KnowledgeBase) -> bool:
    """Whether an action that is possible here needs facts of the predicate; some do only for long objects."""
    is_possible = {LONG_OBJECT: any(sample.length_m for sample in world.samples)}
    return any(
        any(literal.predicate == predicate for literal in action.literals("preconditions"))
        and all(is_possible.get(parameter.type, True) for parameter in action.parameters)
        for action in knowledge_base.actions.values()
    )


def initial_spots(world: WorldFile) -> dict[str, tuple[float, float]]:
    """The start positions of robots that start away from home and chargers: location → (x, y) in metres."""
    return {
        spot_of(robot.name): robot.start[:2]
        for robot in world.robots
        if _charger_at_start(world, robot) is None
    }


def facts_of_robot(world: WorldFile, robot: RobotSpec, knowledge_base: KnowledgeBase) -> Iterator[Fact]:
    """What follows of a robot alone: where it starts, what it is, can and reaches.

    :raises Invalid: if it says to sense what is no predicate.
    """
    refuse_unknown_senses(robot, knowledge_base)
    place = _charger_at_start(world, robot)
    yield Fact(ROBOT_POSITION, (robot.name, NEAR, spot_of(robot.name) if place is None else place))
    yield Fact(ROBOT_ATTRIBUTE, (robot.name, GRIPPER, EMPTY))
    yield Fact(IN_AREA, (robot.name, world.area_of(robot).name))
    for location in world.reach_of(robot):
        yield Fact(REACHES, (robot.name, location.name))
    ruled_out = frozenset[str]() if bears_objects(world, robot) else gripping_tags(knowledge_base)
    for tag in robot.repertoire:
        # A packet may be found by its goals alone, and be named in no action.
        if tag in knowledge_base.constants and tag not in ruled_out:
            yield Fact(CAN, (robot.name, tag))

    fitted = [(HAS_BODY, robot.body.kind), *((HAS_SENSOR, one.kind) for one in robot.sensors)]
    for predicate, kind in fitted:
        if predicate in knowledge_base.predicates and kind in knowledge_base.constants:
            yield Fact(predicate, (robot.name, kind))


def bears_objects(world: WorldFile, robot: RobotSpec) -> bool:
    """False for an avatar beside robots with bodies and software of their own: the objects of these are real."""
    return robot.body.is_solid or not any(one.external and one.body.is_solid for one in world.robots)


def gripping_tags(knowledge_base: KnowledgeBase) -> frozenset[str]:
    """The tags of the actions by which a robot comes to hold an object."""
    return frozenset(
        tag
        for tag, action in knowledge_base.actions.items()
        for slot in ("intended_effects", "other_effects")
        for literal in action.literals(slot)
        if literal.predicate == OBJECT_POSITION and literal.terms[-1] in action.agents
    )


def _charger_at_start(world: WorldFile, robot: RobotSpec) -> str | None:
    """The home or charger that the robot starts at; at a charger that others start at, too, it is the nearest robot."""
    places = {place.name: dist(robot.start[:2], place.at) for place in world.chargers_of(robot)}
    near = [place for place in places if places[place] <= HOME_RADIUS_M]
    if robot.home in near:
        return robot.home
    shared = [place for place in near if _first_at(world, place) == robot.name]
    return min(shared, key=places.__getitem__, default=None)


def _first_at(world: WorldFile, place: str) -> str:
    """The robot that starts nearest to the place."""
    at = world.location(place).at
    return min(world.robots, key=lambda robot: dist(robot.start[:2], at)).name
