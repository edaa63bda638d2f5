"""Where samples can be carried to: who reaches a place, and which places a chain of robots connects."""

from collections import defaultdict

from app.goals.words import natural
from app.world_model.beliefs import CAN, REACHES, Facts, occupants, place_of, robots_in, storing
from robots.world import WorldFile

CARRYING = frozenset({"DOCK", "TRANSPORT", "RELEASE2"})
"""What a robot must be able to do to carry samples from one location to another."""


def carriers(facts: Facts) -> dict[str, frozenset[str]]:
    """The robots that can carry samples, and the locations each reaches."""
    tags: dict[str, set[str]] = defaultdict(set)
    reach: dict[str, set[str]] = defaultdict(set)
    for fact in facts:
        if fact.predicate == CAN:
            tags[fact.args[0]].add(fact.args[1])
        elif fact.predicate == REACHES:
            reach[fact.args[0]].add(fact.args[1])
    return {robot: frozenset(reach[robot]) for robot, known in tags.items() if known >= CARRYING}


def reachers(place: str, facts: Facts) -> tuple[str, ...]:
    """The robots that can carry samples to the place."""
    return tuple(sorted(robot for robot, reach in carriers(facts).items() if place in reach))


def chain_from(start: str, facts: Facts) -> frozenset[str]:
    """The locations that a sample in `start`, a place or a robot's gripper, can be carried to.

    Robots hand it on at places that hold samples; whether those are free just now is the planner's business.
    """
    places = storing(facts)
    reaches = {robot: reach & places for robot, reach in carriers(facts).items()}
    reached = set(reaches.get(start, frozenset())) if start in robots_in(facts) else {start}
    grown = True
    while grown:
        more = {place for reach in reaches.values() if reach & reached for place in reach}
        grown = not more <= reached
        reached |= more
    return frozenset(reached)


def free_places(world: WorldFile, facts: Facts) -> tuple[str, ...]:
    """The places that could take a sample now."""
    free = [p.name for p in world.places if p.capacity > 0 and not occupants(p.name, facts)]
    return tuple(sorted(free, key=natural))


def free_for(sample: str, world: WorldFile, facts: Facts) -> tuple[str, ...]:
    """The locations that could take the sample now, in a berth if they have several, and that it can be carried to.

    Of a sample that is lost: those that some robot can carry samples to.
    """
    lies = place_of(sample, facts)
    reached = frozenset[str]().union(*carriers(facts).values()) if lies is None else chain_from(lies, facts)
    return tuple(
        dict.fromkeys(world.owners[place] for place in free_places(world, facts) if place in reached)
    )
