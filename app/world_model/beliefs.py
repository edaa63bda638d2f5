"""Beliefs about a world as a set of facts, and how news revises them so that they stay consistent.

A robot stands in one place, an object lies in one place, an attribute has one value: news about one of them replaces
what was believed. `vacant` and `clear` follow from where objects lie and robots stand, and are derived, never told.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from planner.fact import Fact
from robots.world import WorldFile

Facts = frozenset[Fact]

ROBOT_POSITION = "robot_position"
OBJECT_POSITION = "object_position"
ROBOT_ATTRIBUTE = "robot_attribute"
TRANSPORTED = "transported"
REACHES = "reaches"
CAN = "can"
IN_AREA = "in_area"
VACANT = "vacant"
CLEAR = "clear"
NEAR = "near"
IN = "in"
GRIPPER = "gripper"
EMPTY = "empty"
FULL = "full"


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """What to add to the facts and what to remove from them; `spots` are new open-floor places (x, y in metres)."""

    add: Facts = frozenset()
    remove: Facts = frozenset()
    spots: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def apply(self, facts: Facts) -> Facts:
        return (facts - self.remove) | self.add


def spot_of(robot: str) -> str:
    """The synthetic location of a robot that stands where no named location is."""
    return f"{robot}_spot"


def position_of(robot: str, facts: Iterable[Fact]) -> Fact | None:
    return next((f for f in facts if f.predicate == ROBOT_POSITION and f.args[0] == robot), None)


def place_of(item: str, facts: Iterable[Fact]) -> str | None:
    """The location or robot the object is in; None if unknown."""
    return next((f.args[2] for f in facts if f.predicate == OBJECT_POSITION and f.args[0] == item), None)


def occupants(place: str, facts: Iterable[Fact]) -> tuple[str, ...]:
    """The objects that lie in a place or a robot's gripper."""
    return tuple(sorted(f.args[0] for f in facts if f.predicate == OBJECT_POSITION and f.args[2] == place))


def revised(world: WorldFile, facts: Facts, news: Iterable[Fact], gone: Iterable[Fact] = ()) -> Facts:
    """The facts after `news` became known and `gone` proved false, consistent again.

    News wins over older belief about the same robot, object, attribute or single-sample place. What is derived
    (`vacant`, `clear`, the gripper of a robot in whose gripper something is known to be) is worked out anew.
    """
    news = tuple(news)
    kept = set(facts) - set(gone)
    for fact in news:
        kept -= _replaced(world, fact, kept)
        kept.add(fact)
    return derived(world, _with_grippers(world, frozenset(kept), news))


def derived(world: WorldFile, facts: Facts) -> Facts:
    """The facts with `vacant` and `clear` worked out from where objects lie and robots stand."""
    areas = {f.args[0]: f.args[1] for f in facts if f.predicate == IN_AREA}
    filled = {f.args[2] for f in facts if f.predicate == OBJECT_POSITION}
    stands = {(f.args[2], areas.get(f.args[0])) for f in facts if f.predicate == ROBOT_POSITION}
    reached = {(f.args[1], areas[f.args[0]]) for f in facts if f.predicate == REACHES and f.args[0] in areas}
    vacant = {Fact(VACANT, (p.name,)) for p in world.locations if p.capacity > 0 and p.name not in filled}
    clear = {Fact(CLEAR, pair) for pair in reached if pair not in stands}
    return frozenset({f for f in facts if f.predicate not in {VACANT, CLEAR}} | vacant | clear)


def _replaced(world: WorldFile, fact: Fact, facts: Iterable[Fact]) -> set[Fact]:
    """The older facts that cannot hold beside `fact`."""
    robots = {robot.name for robot in world.robots}
    match fact.predicate, fact.args:
        case "robot_position", (robot, _, _):
            return {f for f in facts if f.predicate == ROBOT_POSITION and f.args[0] == robot}
        case "robot_attribute", (robot, attribute, value):
            same = {f for f in facts if f.predicate == ROBOT_ATTRIBUTE and f.args[:2] == (robot, attribute)}
            dropped = value == EMPTY and attribute == GRIPPER
            return same | (_inside(robot, facts) if dropped else set())
        case "object_position", (item, _, ref):
            same = {f for f in facts if f.predicate == OBJECT_POSITION and f.args[0] == item}
            single = ref in robots or any(p.name == ref and p.capacity == 1 for p in world.locations)
            return same | (_inside(ref, facts) if single else set())
        case _:
            return set()


def _inside(ref: str, facts: Iterable[Fact]) -> set[Fact]:
    return {f for f in facts if f.predicate == OBJECT_POSITION and f.args[2] == ref}


def _with_grippers(world: WorldFile, facts: Facts, news: Iterable[Fact]) -> Facts:
    """A gripper in which something is known to be is full; one whose object is known elsewhere is empty."""
    told = {f.args[0] for f in news if f.predicate == ROBOT_ATTRIBUTE and f.args[1] == GRIPPER}
    result = set(facts)
    for robot in world.robots:
        full, empty = (Fact(ROBOT_ATTRIBUTE, (robot.name, GRIPPER, value)) for value in (FULL, EMPTY))
        if _inside(robot.name, facts):
            result = (result - {empty}) | {full}
        elif robot.name not in told and full in result:
            result = (result - {full}) | {empty}
    return frozenset(result)
