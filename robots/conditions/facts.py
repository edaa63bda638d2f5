"""Symbolic facts in rel/ref form: the facts that a robot perceives, and the sensor condition for a fact.

Robots are coupled by sensing wherever that suffices (MACTA §5: "no need for the robots to directly communicate"). The
measures are our choice.
"""

from collections.abc import Container, Mapping
from math import isfinite

from robots.conditions.long_objects import AtHandle, HoldsAlone, JointNear
from robots.conditions.own_state import Empty, Holding
from robots.conditions.position import Near
from robots.conditions.sight import Beside, Clear, LiesAt, Vacant
from robots.conditions.verdict import Condition
from robots.errors import RepertoireError
from robots.perception.percepts import LOCATING, Needs, Percepts
from robots.physical.body import GRIPPER_REACH_M
from robots.physical.profile import RobotProfile
from robots.physical.stand_off import STAND_OFF_M
from robots.wire import SymbolicFact

CONDITIONS_OF: Mapping[str, tuple[type[Condition], ...]] = {
    "in": (LiesAt, Holding, AtHandle, Beside),
    "at": (Beside,),
    "near": (Near, Beside),
    "vacant": (Vacant,),
    "clear": (Clear,),
    "brought": (JointNear,),
    "holds_alone": (HoldsAlone,),
    "robot_attribute": (Empty,),
}
"""By predicate, all conditions that `condition_for` may choose."""
ALWAYS_SENSED = frozenset({"brought", "clear", "holds_alone", "vacant"})
"""The predicates, besides relations, that `condition_for` has conditions for."""
NEAR_M = 0.2
IN_THE_WAY_M = 0.5
"""A robot with empty jaws counts as near a place up to this distance: no other robot has room there then."""
AT_M = 0.12
REPORTED: Needs = LOCATING
"""The sensors that a report's facts need; they run while there is a script."""
TRUSTED_M = 3.0
"""The place of a tag beyond this range is not reported: its bearing is too coarse."""
LOOKED_AT_M = 1.5
"""Up to this range a place in view is also reported as vacant."""


def perceived(percepts: Percepts | None) -> tuple[SymbolicFact, ...]:
    """The facts that the robot senses now: its gripper, its place, samples at places, vacant places in view.

    Empty if the sensors for them are off.
    """
    if percepts is None or not percepts.data.holds(REPORTED):
        return ()
    me = percepts.me
    holding = percepts.holding
    facts = [_fact("robot_attribute", me, "gripper", "full" if holding else "empty")]
    if holding:
        facts.append(_fact("in", holding, me))
    facts.extend(_position(percepts))
    for tag in sorted(percepts.tags):
        facts.extend(_whereabouts(percepts, tag))
    facts.extend(_fact("vacant", place) for place in percepts.profile.beacons if _is_empty(percepts, place))
    return tuple(facts)


def _is_empty(percepts: Percepts, place: str) -> bool:
    # NOTE: a long object's tag emits to two sides only; it may lie there unseen.
    if percepts.profile.lengths_m or not percepts.sees(place):
        return False
    at = percepts.locate(place)
    return at is not None and abs(at) <= LOOKED_AT_M and Vacant(place=place).check(percepts).holds


def _position(percepts: Percepts) -> list[SymbolicFact]:
    """The robot's place; its own spot only if it is at no beacon."""
    profile = percepts.profile
    for places in (list(profile.beacons), [name for name in profile.places if name not in profile.beacons]):
        for near_m in (NEAR_M,) if percepts.holding else (NEAR_M, IN_THE_WAY_M):
            found = [(_relation(percepts, place, near_m), place) for place in places]
            facts = [_fact(relation, percepts.me, place) for relation, place in found if relation]
            if facts:
                return facts
    return []


def _relation(percepts: Percepts, place: str, near_m: float) -> str | None:
    beacon = percepts.locate(place)
    point = percepts.approach_point(place)
    if beacon is None or point is None:
        return None
    if abs(beacon - GRIPPER_REACH_M) < AT_M:
        return "at"
    return "near" if abs(point) < near_m else None


def lying_still(percepts: Percepts, tag: str) -> str | None:
    """The place where a sample in view lies still, no robot by it; None if it lies in none, or too far off to tell."""
    at = percepts.locate(tag)
    if at is None or not isfinite(abs(at)) or abs(at) > TRUSTED_M:
        return None
    places = percepts.profile.beacons
    return next((name for name in places if LiesAt(object=tag, place=name).check(percepts).holds), None)


def _whereabouts(percepts: Percepts, tag: str) -> list[SymbolicFact]:
    at = percepts.locate(tag)
    if at is None or not isfinite(abs(at)) or abs(at) > TRUSTED_M:
        return []
    holders = [
        name
        for name in percepts.profile.others
        if _held_by(tag, name, percepts.profile.lengths_m).check(percepts).holds
    ]
    # NOTE: one tick cannot show that it lies still; instead, no robot may be near it.
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


HELD_BY_M = 0.5


def condition_for(fact: SymbolicFact, profile: RobotProfile) -> Condition:  # noqa: PLR0911
    """The sensor condition by which this robot perceives that a fact has become true.

    :raises RepertoireError: if none of its sensors can perceive it.
    """
    match fact.predicate, fact.args:
        case "in", (thing, place) if place in profile.places:
            return LiesAt(object=thing, place=place)
        case "in", (thing, robot) if robot == profile.name:
            return Holding(object=thing)
        case "in", (thing, robot) if robot in profile.others and thing in profile.lengths_m:
            return AtHandle(object=thing, robot=robot)
        case "brought", (thing, place) if thing in profile.lengths_m and place in profile.places:
            # NOTE: wider than TRANSPORT's post-condition: the partner and noise have moved the object since.
            return JointNear(object=thing, place=place, within_m=0.3, facing_rad=0.3)
        case "holds_alone", (robot, thing) if robot == profile.name:
            return HoldsAlone(object=thing)
        case "in", (thing, robot) if robot in profile.others:
            return Beside(target=thing, other=robot, m=HELD_BY_M)
        case "vacant", (place,) if place in profile.places:
            return Vacant(place=place)
        case "clear", (place, *_) if place in profile.places:
            return Clear(place=place)
        case "near", (robot, place) if robot == profile.name and place in profile.places:
            return Near(place=place, within_m=0.2, facing_rad=3.2)
        case "near" | "at", (robot, place) if robot in profile.others and place in profile.places:
            return Beside(target=robot, other=place, m=STAND_OFF_M + 0.2)
        case "robot_attribute", (robot, "gripper", "empty") if robot == profile.name:
            return Empty()
    raise RepertoireError(f"{profile.name} has no sensor for {fact}")
