"""Where samples can be carried to: which crews reach a place, and which places a chain of crews connects.

A crew carries a sample from one location to another: one robot, or two side by side for a long sample.
"""

from collections import defaultdict
from collections.abc import Mapping
from itertools import combinations

from app.domain.goal_language.words import joined, natural_key
from app.domain.world_model.beliefs import (
    CAN,
    IN_AREA,
    REACHES,
    Facts,
    holders,
    place_of,
    robots_in,
    storing,
)
from robots.world import WorldFile

CARRYING = frozenset({"DOCK", "TRANSPORT", "RELEASE2"})
"""The packets that a robot needs to carry samples from one location to another."""
FIRST = frozenset({"DOCK", "TRANSPORT"})
SECOND = frozenset({"TRACK", "DOCK2", "TRANSPORT"})
"""The packets that two robots need to carry a long sample: the robot that grips first, and the one that joins."""
LETTING_GO = ("RELEASE1", "RELEASE2")
"""The packets of release: one robot releases the sample to the other, which puts it down."""

Crews = Mapping[tuple[str, ...], frozenset[str]]
"""Robots that can carry a sample together → the locations that all of them reach."""


def crews_for(sample: str, world: WorldFile, facts: Facts) -> Crews:
    """The crews that can carry the sample."""
    able = _tags(facts)
    reach = _reach(facts)
    areas = _areas(facts)
    if not is_long(sample, world):
        return {(robot,): reach[robot] for robot, tags in able.items() if tags >= CARRYING}
    return {
        (one, other): reach[one] & reach[other]
        for one, other in combinations(sorted(able), 2)
        if areas.get(one) == areas.get(other) and _carry_together(able[one], able[other])
    }


def is_long(sample: str, world: WorldFile) -> bool:
    """True if two robots are needed to carry the sample."""
    return any(one.length_m > 0 for one in world.samples if one.name == sample)


def lacking_crew(sample: str, world: WorldFile, facts: Facts) -> str | None:
    """Why no two robots can carry a long sample, in words; None if two can, or if one is enough."""
    if not is_long(sample, world) or crews_for(sample, world, facts):
        return None
    able = _tags(facts)
    areas = _areas(facts)
    there = defaultdict(list)
    for robot in sorted(robots_in(facts), key=natural_key):
        there[areas.get(robot, "")].append(robot)
    carrying = {area: [r for r in names if "TRANSPORT" in able.get(r, ())] for area, names in there.items()}
    if most := [names for names in carrying.values() if len(names) > 1]:
        wanted = (*sorted(FIRST | SECOND), *LETTING_GO)
        missing = [tag for tag in wanted if not any(tag in able[robot] for robot in most[0])]
        lack = f"can {joined(missing)}" if missing else f"can do its part of {joined(wanted, last='and')}"
        return f"{sample} takes two robots, and none of {joined(most[0], last='and')} {lack}"
    found = [f"in {area} there is only {names[0]}" for area, names in carrying.items() if names]
    return f"{sample} takes two robots that can TRANSPORT, {joined(found, last='and') if found else 'there is none'}"


def reachers(place: str, crews: Crews) -> tuple[tuple[str, ...], ...]:
    """The crews that reach the place."""
    return tuple(sorted(crew for crew, reach in crews.items() if place in reach))


def chain_from(start: str, facts: Facts, crews: Crews) -> frozenset[str]:
    """The locations that a sample in `start`, a place or a robot's gripper, can be carried to.

    Robots hand it on at places that hold samples; the planner considers whether those are free.
    """
    places = storing(facts)
    reaches = {crew: reach & places for crew, reach in crews.items()}
    held = [reach for crew, reach in reaches.items() if start in crew]
    reached = set[str]().union(*held) if start in robots_in(facts) else {start}
    grown = True
    while grown:
        more = {place for reach in reaches.values() if reach & reached for place in reach}
        grown = not more <= reached
        reached |= more
    return frozenset(reached)


def free_places(world: WorldFile, facts: Facts) -> tuple[str, ...]:
    """The places with room for a sample now."""
    filled = holders(facts)
    free = [place.name for place in world.places if place.capacity > 0 and place.name not in filled]
    return tuple(sorted(free, key=natural_key))


def free_for(sample: str, world: WorldFile, facts: Facts) -> tuple[str, ...]:
    """The locations with room for the sample now, in a berth if they have several, and that it can be carried to.

    For a lost sample: those that some crew for it reaches.
    """
    lies = place_of(sample, facts)
    crews = crews_for(sample, world, facts)
    reached = frozenset[str]().union(*crews.values()) if lies is None else chain_from(lies, facts, crews)
    return tuple(
        dict.fromkeys(world.location_of[place] for place in free_places(world, facts) if place in reached)
    )


def _carry_together(one: frozenset[str], other: frozenset[str]) -> bool:
    docks = (one >= FIRST and other >= SECOND) or (other >= FIRST and one >= SECOND)
    release1, release2 = LETTING_GO
    releases = (release1 in one and release2 in other) or (release1 in other and release2 in one)
    return docks and releases


def _tags(facts: Facts) -> dict[str, frozenset[str]]:
    """The packet tags of each robot."""
    return _second_by_first(facts, CAN)


def _reach(facts: Facts) -> Mapping[str, frozenset[str]]:
    """The locations each robot reaches."""
    return defaultdict(frozenset, _second_by_first(facts, REACHES))


def _areas(facts: Facts) -> Mapping[str, str]:
    return {fact.args[0]: fact.args[1] for fact in facts if fact.predicate == IN_AREA}


def _second_by_first(facts: Facts, predicate: str) -> dict[str, frozenset[str]]:
    found: dict[str, set[str]] = defaultdict(set)
    for fact in facts:
        if fact.predicate == predicate:
            found[fact.args[0]].add(fact.args[1])
    return {name: frozenset(values) for name, values in found.items()}
