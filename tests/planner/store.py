"""The sample store as a planning problem, straight from its world file."""

from collections.abc import Iterable, Mapping
from math import dist

from planner.fact import Fact
from planner.problem.interface import PlanningProblem
from robots.world import WorldFile, load_world
from robots.world.generate import generate_world, store_shape

Points = dict[str, tuple[float, float]]


def small_store() -> WorldFile:
    """A world of one aisle; reading its problems as PDDL takes half as long as those of the sample store."""
    return generate_world(store_shape(aisles=1, yard_robots=2, doors=1, bays=2, samples=1))


def inside(sample: str, place: str) -> Fact:
    return Fact("object_position", (sample, "in", place))


def store_problem(
    goals: Iterable[Fact],
    *,
    samples: Mapping[str, str] | None = None,
    robots_at: Mapping[str, str] | None = None,
    world: WorldFile | None = None,
) -> PlanningProblem:
    """A problem of the sample store.

    :param samples: where the samples lie, instead of the world's own.
    :param robots_at: where robots stand, instead of at home.
    """
    world = world or load_world("sample_store")
    places: Points = {place.name: place.at for place in world.locations}
    lying = dict(samples) if samples is not None else {sample.name: sample.at for sample in world.samples}
    standing = {robot.name: (robots_at or {}).get(robot.name, robot.home or "") for robot in world.robots}
    areas = {robot.name: world.area_of(robot).name for robot in world.robots}
    objects = dict.fromkeys(places, "location") | dict.fromkeys(lying, "object")
    objects |= dict.fromkeys(standing, "robot") | dict.fromkeys(areas.values(), "area")
    facts = {inside(sample, place) for sample, place in lying.items()}
    facts |= {
        Fact("vacant", (p.name,)) for p in world.locations if p.capacity and p.name not in lying.values()
    }
    functions: dict[tuple[str, tuple[str, ...]], float] = {}
    for robot in world.robots:
        name = robot.name
        area = areas[robot.name]
        reach = [place.name for place in world.reach_of(robot)]
        facts |= {Fact("robot_position", (name, "near", standing[name])), Fact("in_area", (name, area))}
        facts |= {Fact("robot_attribute", (name, "gripper", "empty"))}
        facts |= {Fact("can", (name, tag)) for tag in robot.repertoire}
        facts |= {Fact("reaches", (name, place)) for place in reach}
        taken = {standing[other] for other in standing if areas[other] == area}
        facts |= {Fact("clear", (place, area)) for place in reach if place not in taken}
        functions[("speed_m_s", (name,))] = robot.speed_m_s
        functions |= {
            ("distance_m", (a, b)): dist(places[a], places[b]) for a in reach for b in reach if a != b
        }
    return PlanningProblem(objects=objects, facts=frozenset(facts), goals=tuple(goals), functions=functions)
