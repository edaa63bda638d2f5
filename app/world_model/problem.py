"""The planning problem that the world model poses: objects, facts and the numbers durations are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from math import dist

from app.world_model.beliefs import (
    OBJECT_POSITION,
    REACHES,
    TRANSPORTED,
    Facts,
    position_of,
    robots_in,
    spot_of,
)
from planner import Fact, PlanNet, PlanningProblem
from robots.world import RobotSpec, WorldFile

ROBOT, OBJECT, LOCATION, AREA = "robot", "object", "location", "area"
Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reservation:
    """Robots, locations and samples that something else uses."""

    robots: frozenset[str] = frozenset()
    locations: frozenset[str] = frozenset()
    samples: frozenset[str] = frozenset()

    @property
    def names(self) -> frozenset[str]:
        return self.robots | self.locations | self.samples

    def shared(self, other: "Reservation") -> tuple[str, ...]:
        """What both reserve, in alphabetical order."""
        return tuple(sorted(self.names & other.names))

    def overlaps(self, other: "Reservation") -> bool:
        return bool(self.names & other.names)


NOTHING_RESERVED = Reservation()


def reservation_of(plan_net: PlanNet) -> Reservation:
    """The robots, locations and samples that a plan-net's actions use."""
    facts = [f for a in plan_net.actions for f in (*a.preconditions, *a.deletes, *a.effects)]
    robots = frozenset(plan_net.robots) | robots_in(facts)
    locations = {place for fact in facts for place in _locations(fact)} - robots
    samples = {f.args[0] for f in facts if f.predicate in {OBJECT_POSITION, TRANSPORTED}}
    return Reservation(robots=robots, locations=frozenset(locations), samples=frozenset(samples))


def _locations(fact: Fact) -> Sequence[str]:
    match fact.predicate, fact.args:
        case (("robot_position" | "object_position"), (_, _, ref)):
            return (ref,)
        case (("vacant" | "clear"), (location, *_)):
            return (location,)
        case "transported", (_, _, _, ref1, _, ref2):
            return (ref1, ref2)
        case _:
            return ()


def objects_of(world: WorldFile) -> dict[str, str]:
    """Every object of the world and its type; each robot's open-floor spot is a location."""
    named = {place.name: LOCATION for place in world.locations}
    named |= {sample.name: OBJECT for sample in world.samples}
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
) -> PlanningProblem:
    """What is to be planned, from what is believed.

    :param spots: where open-floor locations are, (x, y) in metres; a robot's start where it is not told.
    :param reserved: what running missions use and the plan must leave alone.
    """
    free = frozenset(fact for fact in facts if not _withheld(fact, reserved))
    functions: dict[tuple[str, tuple[str, ...]], float] = {}
    for robot in world.robots:
        functions["speed_m_s", (robot.name,)] = robot.speed_m_s
        points = _points(world, robot, free, spots or {})
        for (one, here), (other, there) in permutations(points.items(), 2):
            functions["distance_m", (one, other)] = round(dist(here, there), 3)
    objects = objects_of(world)
    unused = {spot_of(robot.name) for robot in world.robots} - {name for fact in free for name in fact.args}
    return PlanningProblem(
        objects={name: kind for name, kind in objects.items() if name not in unused},
        facts=free,
        goals=tuple(goals),
        functions=functions,
    )


def _points(world: WorldFile, robot: RobotSpec, facts: Facts, spots: Mapping[str, Point]) -> dict[str, Point]:
    """The places a robot drives between."""
    reached = {f.args[1] for f in facts if f.predicate == REACHES and f.args[0] == robot.name}
    points = {place.name: place.at for place in world.locations if place.name in reached}
    position = position_of(robot.name, facts)
    if position is not None and position.args[2] == spot_of(robot.name):
        points[spot_of(robot.name)] = spots.get(spot_of(robot.name), robot.start[:2])
    return points


def _withheld(fact: Fact, reserved: Reservation) -> bool:
    match fact.predicate:
        case "can":
            return fact.args[0] in reserved.robots
        case "clear" | "vacant":
            return fact.args[0] in reserved.locations
        case "object_position":
            return fact.args[0] in reserved.samples
        case _:
            return False
