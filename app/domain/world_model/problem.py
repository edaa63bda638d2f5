"""The planning problem from the world model: objects, facts, and the distances and speeds for durations."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from app.domain.world_model.beliefs import (
    CLOSED,
    LIFT_AT,
    OBJECT_POSITION,
    OPENED,
    OPERABLE,
    OWN_SPOT,
    REACHES,
    ROBOT_POSITION,
    ZONE_CLEAR,
    Facts,
    robots_in_zones,
    spot_of,
)
from app.domain.world_model.passages import functions_of, passages, unheld
from app.domain.world_model.reservation import NOTHING_RESERVED, Reservation, is_withheld
from app.domain.world_model.senses import Perceives, restricted_senses
from app.domain.world_model.zones import crossings, spots_in_zones
from planner import Access, Crossing, Fact, KnowledgeBase, PlanningProblem
from robots.world import WorldFile, ZoneRule
from robots.world.file import ROBOT_WIDTH_M
from robots.world.slopes import Paced, level_way_m

ROBOT = "robot"
LOCATION = "location"
AREA = "area"
OBJECT = "object"
LONG_OBJECT = "long_object"
ZONE = "zone"
DOOR = "door"
LIFT = "lift"
LEVEL = "level"
Point = tuple[float, float]
Crossings = dict[tuple[str, str], tuple[Crossing, ...]]


def objects_of(world: WorldFile) -> dict[str, str]:
    """Every object of the world and its type; each robot's open-floor spot is a location, each zone
    for one robot a zone, and the doorway of a door for one robot, too."""
    named = {place.name: LOCATION for place in world.places}
    named |= {sample.name: LONG_OBJECT if sample.length_m else OBJECT for sample in world.samples}
    named |= {zone.name: ZONE for zone in world.zones_of(ZoneRule.ONE_ROBOT)}
    for one in world.peripherals:
        named |= {one.name: LIFT if one.is_lift else DOOR, **dict.fromkeys(one.levels, LEVEL)}
        named |= {one.passage: ZONE} if one.passage else {}
    for robot in world.robots:
        named |= {robot.name: ROBOT, spot_of(robot.name): LOCATION, world.area_of(robot).name: AREA}
    return named


def planning_problem(
    world: WorldFile,
    facts: Facts,
    goals: Sequence[Fact],
    *,
    spots: Mapping[str, Point] | None = None,
    reserved: Reservation = NOTHING_RESERVED,
    knowledge_base: KnowledgeBase | None = None,
    perceives: Perceives | None = None,
    is_held: bool = False,
) -> PlanningProblem:
    """The planning problem for these goals from the believed facts.

    :param spots: positions of open-floor locations, (x, y) in metres; by default the robot's start.
    :param reserved: what running missions still need and the plan must not use.
    :param knowledge_base: leaves out the facts that none of its actions mentions; None: none is.
    :param perceives: what robots sense by their sensors that do not say what they sense; None: all.
    :param is_held: the mission that the plan is for keeps open the doors that are open, which close by themselves else.
    """
    objects = objects_of(world)
    has_zones = knowledge_base is None or ZONE_CLEAR in knowledge_base.predicates
    if not has_zones:
        objects = {name: kind for name, kind in objects.items() if kind != ZONE}
    with_peripherals = bool(world.peripherals) and has_peripherals(knowledge_base)
    if not with_peripherals:
        objects = {name: kind for name, kind in objects.items() if kind not in (DOOR, LIFT, LEVEL)}
    meant = (
        None if knowledge_base is None else knowledge_base.mentioned.union(goal.predicate for goal in goals)
    )
    # A robot may report a sample, in passing, before it is one of the world's.
    free = frozenset(
        fact
        for fact in facts
        if (meant is None or fact.predicate in meant)
        and not is_withheld(fact, reserved)
        and (fact.predicate != OBJECT_POSITION or fact.args[0] in objects)
    )
    functions: dict[tuple[str, tuple[str, ...]], float] = {
        ("speed_m_s", (robot.name,)): robot.speed_m_s for robot in world.robots
    }
    functions |= batteries_of(world)
    # Distances come from all facts, for a robot may drive off a reserved place.
    points = _points(world, spots or {})
    ways = _ways(facts)
    functions |= _distances(points, ways, world)
    stands = {spot_of(robot.name): points[spot_of(robot.name)] for robot in world.robots}
    crossed: Crossings = {}
    if has_zones and world.zones_of(ZoneRule.ONE_ROBOT):
        free, crossed = _with_zones(world, free, facts, stands, ways)
    access = Access()
    if with_peripherals:
        through = passages(world, stands, ways)
        functions = {call: value for call, value in functions.items() if call[1] not in through.walled}
        functions |= functions_of(world)
        access = through.access
        free -= frozenset() if is_held else unheld(world)
        if has_zones:
            every = crossed.keys() | through.crossings.keys()
            crossed = {way: (*crossed.get(way, ()), *through.crossings.get(way, ())) for way in sorted(every)}
    unused = {spot_of(robot.name) for robot in world.robots} - {name for fact in free for name in fact.args}
    return PlanningProblem(
        objects={name: kind for name, kind in objects.items() if name not in unused},
        facts=free,
        goals=tuple(goals),
        functions=functions,
        crossings=crossed,
        senses={} if knowledge_base is None else restricted_senses(world, knowledge_base, perceives),
        access=access,
    )


def batteries_of(world: WorldFile) -> dict[tuple[str, tuple[str, ...]], float]:
    """What robots' batteries hold in joules, and the watts that they gain where they are charged.

    Robots with software of their own charge by themselves.
    """
    from robots.physical.energy import load_powers  # here: to check world files needs no numpy

    powers = load_powers()
    gained_w = powers.charger_w - powers.electronics_w
    held: dict[tuple[str, tuple[str, ...]], float] = {
        ("capacity_j", (robot.name,)): 3600 * robot.battery_wh for robot in world.robots
    }
    return held | {
        ("charger_w", (robot.name, place.name)): gained_w
        for robot in world.robots
        if not robot.external
        for place in world.chargers_of(robot)
    }


def has_peripherals(knowledge_base: KnowledgeBase | None) -> bool:
    """Whether the knowledge base knows doors, hatches and lifts; None: any does."""
    return knowledge_base is None or {OPENED, CLOSED, LIFT_AT, OPERABLE} <= knowledge_base.predicates.keys()


def _with_zones(
    world: WorldFile,
    free: Facts,
    facts: Facts,
    stands: Mapping[str, Point],
    ways: Mapping[str, set[str]],
) -> tuple[Facts, Crossings]:
    """The free facts without those of zones in which a robot stands on the open floor, and what ways do to zones.

    Where several robots stand in a zone, it is not clear once one of them has left.

    :param facts: all of them. :param stands: by open-floor location.
    """
    inside = robots_in_zones(facts, spots_in_zones(world, stands))
    crossed = {
        way: tuple(
            replace(one, leaves=one.enters) if len(inside.get(one.zone, ())) > 1 else one for one in each
        )
        for way, each in crossings(world, stands, ways).items()
    }
    held = {Fact(ZONE_CLEAR, (zone,)) for zone in inside}
    return free - held, crossed


def _points(world: WorldFile, spots: Mapping[str, Point]) -> dict[str, Point]:
    """The positions of all locations; a robot's spot is at its start unless given."""
    starts = {spot_of(robot.name): robot.start[:2] for robot in world.robots}
    return {place.name: place.at for place in world.places} | starts | dict(spots)


def _ways(facts: Facts) -> Mapping[str, set[str]]:
    """For each place, those that some robot can drive to from there: what it reaches, and its own open-floor spot."""
    driven: dict[str, set[str]] = defaultdict(set)
    for fact in facts:
        if fact.predicate in (REACHES, OWN_SPOT):
            driven[fact.args[0]].add(fact.args[1])
        elif fact.predicate == ROBOT_POSITION and fact.args[2] == spot_of(fact.args[0]):
            driven[fact.args[0]].add(fact.args[2])
    ways: dict[str, set[str]] = defaultdict(set)
    for places in driven.values():
        for place in places:
            ways[place] |= places
    return ways


def _distances(
    points: Mapping[str, Point], ways: Mapping[str, set[str]], world: WorldFile
) -> dict[tuple[str, tuple[str, ...]], float]:
    """The straight distances in metres of level ground, both ways: slopes and slow zones count by the time that they
    take."""
    limited = tuple(_limited(world))
    distances: dict[tuple[str, tuple[str, ...]], float] = {}
    for one in sorted(ways.keys() & points.keys()):
        for other in sorted(ways[one] & points.keys()):
            if one < other:
                distance_m = round(level_way_m(points[one], points[other], world.slopes, limited), 3)
                distances["distance_m", (one, other)] = distances["distance_m", (other, one)] = distance_m
    return distances


def _limited(world: WorldFile) -> Iterator[Paced]:
    """The slow zones, and the share of its speed that the fastest robot keeps in each, from when its hull is inside.

    NOTE: one function gives the distances of all robots, so the time of slower ones is over-estimated.
    """
    fastest_m_s = max(robot.speed_m_s for robot in world.robots)
    for zone in world.zones_of(ZoneRule.SLOW):
        if zone.max_speed_m_s is not None and zone.max_speed_m_s < fastest_m_s:
            yield zone.grown(ROBOT_WIDTH_M / 2), zone.max_speed_m_s / fastest_m_s
