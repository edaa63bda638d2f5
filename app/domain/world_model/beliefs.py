"""Beliefs about a world: facts in the planner's form, and how news revises them so that they stay consistent.

A robot stands in one place, an object lies in one place, an attribute has one value, a place holds one object, a door
is open or closed, a lift is at one level: a new fact about one of them replaces the old one. `vacant`, `clear` and
`zone_clear` are derived from the positions of objects and robots; `brought` lasts as long as a robot holds the object,
`holds_alone` as long as it holds it alone.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from planner import Fact

Facts = frozenset[Fact]

ROBOT_POSITION = "robot_position"
OBJECT_POSITION = "object_position"
ROBOT_ATTRIBUTE = "robot_attribute"
TRANSPORTED = "transported"
BROUGHT = "brought"
REACHES = "reaches"
CAN = "can"
IN_AREA = "in_area"
OWN_SPOT = "own_spot"
HAS_BODY = "has_body"
HAS_SENSOR = "has_sensor"
SOLID = "solid"
VACANT = "vacant"
CLEAR = "clear"
OPENED = "opened"
CLOSED = "closed"
LIFT_AT = "lift_at"
OPERABLE = "operable"
ON_WAY = "on_way"
STATES = frozenset({OPENED, CLOSED, LIFT_AT})
"""Predicates of how doors, hatches and lifts stand."""
IN_ZONE = "in_zone"
ZONE_CLEAR = "zone_clear"
NEAR = "near"
IN = "in"
GRIPPER = "gripper"
EMPTY = "empty"
FULL = "full"

EXCLUSIVE = STATES | {ROBOT_POSITION, ROBOT_ATTRIBUTE, OBJECT_POSITION}
"""Predicates whose facts can be contradicted by other facts."""
STRUCTURAL = frozenset(
    {CAN, HAS_BODY, HAS_SENSOR, IN_AREA, IN_ZONE, ON_WAY, OPERABLE, OWN_SPOT, REACHES, SOLID}
)
"""Predicates of what follows from the world alone."""
FOLLOWING = frozenset({CLEAR, ZONE_CLEAR})
"""Predicates whose facts always follow from where robots are."""
DERIVED = FOLLOWING | {VACANT}
"""Predicates whose facts follow from where robots and objects are, unless news say otherwise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """Facts to add and to remove; `notes` say in words what was lost."""

    add: Facts = frozenset()
    remove: Facts = frozenset()
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


def robots_in(facts: Iterable[Fact]) -> frozenset[str]:
    return frozenset(f.args[0] for f in facts if f.predicate in {IN_AREA, ROBOT_ATTRIBUTE, ROBOT_POSITION})


def belief_change(facts: Facts, news: Iterable[Fact], gone: Iterable[Fact] = ()) -> Change:
    """The change when `news` become known and `gone` prove false; the resulting facts are consistent."""
    after = revise_beliefs(facts, news, gone)
    return Change(add=after - facts, remove=facts - after)


def revise_beliefs(facts: Facts, news: Iterable[Fact], gone: Iterable[Fact] = ()) -> Facts:
    """The facts after `news` became known and `gone` proved false.

    News wins over older belief. `vacant(l)` as news means that nothing lies there any longer; `clear` and `zone_clear`
    are always derived.
    """
    kept = set(facts) - set(gone)
    news = list(news)
    zones = _zones_of((*facts, *news))
    news = [fact for fact in news if fact.predicate not in FOLLOWING]
    robots = robots_in(kept)
    exclusive = {fact for fact in kept if fact.predicate in EXCLUSIVE}
    compatible = kept - exclusive
    for fact in news:
        exclusive = {old for old in exclusive if not _contradicts(fact, old, robots)}
        (exclusive if fact.predicate in EXCLUSIVE else compatible).add(fact)
    kept = exclusive | compatible
    places = storing(facts | frozenset(news))
    held = frozenset(fact for fact in kept if not _is_outdated(fact, kept))
    return _with_derived(_with_grippers(held, _holders(facts), news), places, zones)


def contradiction(facts: Facts, news: Sequence[Fact]) -> tuple[Fact, Fact] | None:
    """Two of the news that cannot both hold, in whichever order; None if there are none.

    NOTE: `clear` and `zone_clear` as news are ignored: they are always derived.
    """
    after = revise_beliefs(facts, news)
    for lost in news:
        if lost in after or lost.predicate in FOLLOWING:
            continue
        for other in news:
            if other != lost and not {lost, other} <= revise_beliefs(facts, [lost, other]):
                return lost, other
    return None


def _is_outdated(fact: Fact, facts: Collection[Fact]) -> bool:
    """True for a fact about an object held by robots (`brought`, `holds_alone`) whose holders have changed."""
    match fact.predicate, fact.args:
        case "brought", (item, _):
            return not _holding(item, facts)
        case "holds_alone", (robot, item):
            return _holding(item, facts) != {robot}
        case _:
            return False


def _holding(item: str, facts: Collection[Fact]) -> set[str]:
    """The robots that hold the object."""
    robots = robots_in(facts)
    return {f.args[2] for f in facts if f.predicate == OBJECT_POSITION and f.args[0] == item} & robots


def _contradicts(new: Fact, old: Fact, robots: frozenset[str]) -> bool:
    """True if the two cannot both hold. Two robots may hold one object between them (MACTA §5)."""
    if new.predicate in STATES:
        return old.predicate in STATES and new.args[0] == old.args[0]
    match new.predicate, new.args, old.predicate, old.args:
        case "robot_position", (robot, *_), "robot_position", (other, *_):
            return robot == other
        case "robot_attribute", (robot, attribute, _), "robot_attribute", (other, same, _):
            return (robot, attribute) == (other, same)
        case ("robot_attribute", (place, "gripper", "empty"), "object_position", (_, _, ref)) | (
            "vacant",
            (place,),
            "object_position",
            (_, _, ref),
        ):
            return place == ref
        case "object_position", (item, _, ref), "object_position", (other, _, place):
            jointly = ref in robots and place in robots and ref != place
            return ref == place or (item == other and not jointly)
        case _:
            return False


def storing(facts: Facts) -> frozenset[str]:
    """The locations that can hold a sample: those known to be vacant or filled."""
    robots = robots_in(facts)
    vacant = {f.args[0] for f in facts if f.predicate == VACANT}
    filled = {f.args[2] for f in facts if f.predicate == OBJECT_POSITION and f.args[2] not in robots}
    return frozenset(vacant | filled)


def robots_in_zones(facts: Facts, spots: Iterable[tuple[str, str]] = ()) -> Mapping[str, frozenset[str]]:
    """Zone for one robot → the robots that stand in it, where there are some.

    :param spots: locations on the open floor that lie in a zone, and the zone.
    """
    areas = {f.args[0]: f.args[1] for f in facts if f.predicate == IN_AREA}
    zones: dict[tuple[str, str | None], set[str]] = defaultdict(set)
    for fact in facts:
        if fact.predicate == IN_ZONE:
            place, area, zone = fact.args
            zones[place, area].add(zone)
    for spot, zone in spots:
        for any_area in {None, *areas.values()}:
            zones[spot, any_area].add(zone)
    inside: dict[str, set[str]] = defaultdict(set)
    for fact in facts if zones else ():
        if fact.predicate == ROBOT_POSITION:
            for zone in zones.get((fact.args[2], areas.get(fact.args[0])), ()):
                inside[zone].add(fact.args[0])
    return {zone: frozenset(robots) for zone, robots in inside.items()}


def _zones_of(facts: Iterable[Fact]) -> frozenset[str]:
    """The zones for one robot that the facts name."""
    return frozenset(fact.args[-1] for fact in facts if fact.predicate in (IN_ZONE, ZONE_CLEAR))


def _with_derived(facts: Facts, places: frozenset[str], zones: frozenset[str]) -> Facts:
    """The facts with `vacant`, `clear` and `zone_clear` derived from the positions of objects and robots."""
    areas = {f.args[0]: f.args[1] for f in facts if f.predicate == IN_AREA}
    filled = {f.args[2] for f in facts if f.predicate == OBJECT_POSITION}
    stands = {(f.args[2], areas.get(f.args[0])) for f in facts if f.predicate == ROBOT_POSITION}
    reached = {(f.args[1], areas[f.args[0]]) for f in facts if f.predicate == REACHES and f.args[0] in areas}
    vacant = {Fact(VACANT, (place,)) for place in places - filled}
    clear = {Fact(CLEAR, pair) for pair in reached if pair not in stands}
    free = {Fact(ZONE_CLEAR, (zone,)) for zone in zones - robots_in_zones(facts).keys()}
    return frozenset({f for f in facts if f.predicate not in DERIVED} | vacant | clear | free)


def _with_grippers(facts: Facts, held_before: frozenset[str], news: Iterable[Fact]) -> Facts:
    """The facts with a gripper that holds an object full, and one that no longer holds its object empty.

    NOTE: a robot's own report on its gripper is kept: it may hold an object that is in no fact.
    """
    told = {f.args[0] for f in news if f.predicate == ROBOT_ATTRIBUTE and f.args[1] == GRIPPER}
    holding = _holders(facts)
    result = set(facts)
    for robot in robots_in(facts):
        full, empty = (Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, value)) for value in (FULL, EMPTY))
        if robot in holding:
            result = (result - {empty}) | {full}
        elif robot in held_before and robot not in told:
            result = (result - {full}) | {empty}
    return frozenset(result)


def _holders(facts: Iterable[Fact]) -> frozenset[str]:
    """Where objects are: locations and robots."""
    return frozenset(f.args[2] for f in facts if f.predicate == OBJECT_POSITION)
