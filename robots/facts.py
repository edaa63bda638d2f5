"""What a robot perceives, as symbolic facts in rel/ref form, for its reports."""

from collections.abc import Container
from math import isfinite

from robots.body import GRIPPER_REACH_M
from robots.conditions import AtHandle, Beside, Condition, LiesAt
from robots.percepts import LOCATING, Needs, Percepts
from robots.wire import SymbolicFact

NEAR_M = 0.2
AT_M = 0.12
REPORTED: Needs = LOCATING
"""What a report tells of is sensed as long as there is anything to report of."""
TRUSTED_M = 3.0
"""A tag farther off than this is not said to lie anywhere: its bearing is too coarse."""


def perceived(percepts: Percepts | None) -> tuple[SymbolicFact, ...]:
    """The facts that hold as far as the robot can sense right now: its gripper, its place, samples at
    locations.

    Of places it names those on its map. Nothing if it does not sense.
    """
    if percepts is None or not percepts.data.holds(REPORTED):
        return ()
    me, holding = percepts.me, percepts.holding
    facts = [_fact("robot_attribute", me, "gripper", "full" if holding else "empty")]
    if holding:
        facts.append(_fact("in", holding, me))
    facts.extend(_position(percepts))
    for tag in sorted(percepts.tags):
        facts.extend(_whereabouts(percepts, tag))
    return tuple(facts)


def _position(percepts: Percepts) -> list[SymbolicFact]:
    """Where it stands; its own spot only if it stands by no beacon."""
    profile = percepts.profile
    for places in (list(profile.beacons), [name for name in profile.places if name not in profile.beacons]):
        found = [(_relation(percepts, place), place) for place in places]
        facts = [_fact(relation, percepts.me, place) for relation, place in found if relation]
        if facts:
            return facts
    return []


def _relation(percepts: Percepts, place: str) -> str | None:
    beacon, point = percepts.locate(place), percepts.approach_point(place)
    if beacon is None or point is None:
        return None
    if abs(beacon - GRIPPER_REACH_M) < AT_M:
        return "at"
    return "near" if abs(point) < NEAR_M else None


def _whereabouts(percepts: Percepts, tag: str) -> list[SymbolicFact]:
    at = percepts.locate(tag)
    if at is None or not isfinite(abs(at)) or abs(at) > TRUSTED_M:
        return []
    holders = [
        name
        for name in percepts.profile.others
        if _held_by(tag, name, percepts.profile.lengths_m).check(percepts).holds
    ]
    # NOTE: one look does not tell whether it lies still; that no robot is by it does.
    places = [
        name
        for name in percepts.profile.beacons
        if LiesAt(object=tag, place=name, still_s=0.0).check(percepts).holds
    ]
    return [_fact("in", tag, name) for name in (holders or places)[:1]]


def _held_by(tag: str, robot: str, long: Container[str]) -> Condition:
    return (
        AtHandle(object=tag, robot=robot, still_s=0.0)
        if tag in long
        else Beside(target=tag, other=robot, m=0.45)
    )


def _fact(predicate: str, *args: str) -> SymbolicFact:
    return SymbolicFact(predicate=predicate, args=args)
