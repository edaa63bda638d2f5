"""Beliefs about a world: facts in the planner's form, and how news revises them so that they stay consistent.

A robot stands in one place, an object lies in one place, an attribute has one value, a place holds one object, a door
is open or closed, a lift is at one level: a new fact about one of them replaces the old one. `vacant`, `clear` and
`zone_clear` are derived from the positions of objects and robots; `brought` lasts as long as a robot holds the object,
`holds_alone` as long as it holds it alone.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from planner import Fact

Facts = frozenset[Fact]
_Grouped = defaultdict[str, set[Fact]]
"""Facts by predicate."""

ROBOT_POSITION = "robot_position"
OBJECT_POSITION = "object_position"
ROBOT_ATTRIBUTE = "robot_attribute"
TRANSPORTED = "transported"
BROUGHT = "brought"
HOLDS_ALONE = "holds_alone"
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

OF_ROBOTS = frozenset({IN_AREA, ROBOT_ATTRIBUTE, ROBOT_POSITION})
"""Predicates whose facts have a robot first; each robot has some of them."""
CONTRADICTED: Mapping[str, Collection[str]] = {
    **dict.fromkeys(STATES, STATES),
    ROBOT_POSITION: (ROBOT_POSITION,),
    ROBOT_ATTRIBUTE: (ROBOT_ATTRIBUTE, OBJECT_POSITION),
    OBJECT_POSITION: (OBJECT_POSITION,),
    VACANT: (OBJECT_POSITION,),
}
"""By predicate, those of facts that a fact with it can contradict."""
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


def holders(facts: Iterable[Fact]) -> frozenset[str]:
    """Where objects are: locations and robots."""
    return frozenset(fact.args[2] for fact in facts if fact.predicate == OBJECT_POSITION)


def robots_in(facts: Iterable[Fact]) -> frozenset[str]:
    return frozenset(fact.args[0] for fact in facts if fact.predicate in OF_ROBOTS)


def belief_change(facts: Facts, news: Iterable[Fact], gone: Iterable[Fact] = ()) -> Change:
    """The change when `news` become known and `gone` prove false; the resulting facts are consistent."""
    after = revise_beliefs(facts, news, gone)
    return Change(add=after - facts, remove=facts - after)


def revise_beliefs(facts: Facts, news: Iterable[Fact], gone: Iterable[Fact] = ()) -> Facts:
    """The facts after `news` became known and `gone` proved false.

    News wins over older belief. `vacant(l)` as news means that nothing lies there any longer; `clear` and `zone_clear`
    are always derived.
    """
    news = list(news)
    kept = _by_predicate(facts)
    held_before = holders(kept[OBJECT_POSITION])
    with_news = _by_predicate(news, kept)
    zones = frozenset(fact.args[-1] for name in (IN_ZONE, ZONE_CLEAR) for fact in with_news[name])
    places = _storing(with_news)
    for fact in gone:
        kept[fact.predicate].discard(fact)
    robots = _robots_in(kept)
    for fact in news:
        if fact.predicate in FOLLOWING:
            continue
        for name in CONTRADICTED.get(fact.predicate, ()):
            kept[name] = {old for old in kept[name] if not _contradicts(fact, old, robots)}
        kept[fact.predicate].add(fact)
    for name in (BROUGHT, HOLDS_ALONE):
        kept[name] = {fact for fact in kept[name] if not _is_outdated(fact, kept)}
    kept[ROBOT_ATTRIBUTE] = _with_grippers(kept, held_before, news)
    return _with_derived(kept, places, zones)


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


def _by_predicate(facts: Iterable[Fact], known: _Grouped | None = None) -> _Grouped:
    """Facts by their predicate, in sets of their own, together with those that are grouped already."""
    grouped: _Grouped = defaultdict(set)
    if known is not None:
        for name, of_name in known.items():
            grouped[name] = set(of_name)
    for fact in facts:
        grouped[fact.predicate].add(fact)
    return grouped


def _robots_in(facts: _Grouped) -> frozenset[str]:
    return robots_in(chain.from_iterable(facts[name] for name in OF_ROBOTS))


def _is_outdated(fact: Fact, facts: _Grouped) -> bool:
    """True for a fact about an object held by robots (`brought`, `holds_alone`) whose holders have changed."""
    if fact.predicate == BROUGHT:
        return not _holding(fact.args[0], facts)
    return _holding(fact.args[1], facts) != {fact.args[0]}


def _holding(item: str, facts: _Grouped) -> frozenset[str]:
    """The robots that hold the object."""
    return _robots_in(facts) & {fact.args[2] for fact in facts[OBJECT_POSITION] if fact.args[0] == item}


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
    return _storing(_by_predicate(facts))


def _storing(facts: _Grouped) -> frozenset[str]:
    vacant = {fact.args[0] for fact in facts[VACANT]}
    return (holders(facts[OBJECT_POSITION]) - _robots_in(facts)) | vacant


def robots_in_zones(
    facts: Collection[Fact], spots: Iterable[tuple[str, str]] = ()
) -> Mapping[str, frozenset[str]]:
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


def _with_derived(facts: _Grouped, places: frozenset[str], zones: frozenset[str]) -> Facts:
    """The facts with `vacant`, `clear` and `zone_clear` derived from the positions of objects and robots."""
    areas = {fact.args[0]: fact.args[1] for fact in facts[IN_AREA]}
    stands = {(fact.args[2], areas.get(fact.args[0])) for fact in facts[ROBOT_POSITION]}
    reached = {(fact.args[1], areas[fact.args[0]]) for fact in facts[REACHES] if fact.args[0] in areas}
    inside = robots_in_zones([*facts[IN_AREA], *facts[IN_ZONE], *facts[ROBOT_POSITION]]) if zones else {}
    return frozenset(
        chain(
            *(of_name for name, of_name in facts.items() if name not in DERIVED),
            (Fact(VACANT, (place,)) for place in places - holders(facts[OBJECT_POSITION])),
            (Fact(CLEAR, pair) for pair in reached - stands),
            (Fact(ZONE_CLEAR, (zone,)) for zone in zones - inside.keys()),
        )
    )


def _with_grippers(facts: _Grouped, held_before: frozenset[str], news: Iterable[Fact]) -> set[Fact]:
    """The robots' attributes, a gripper that holds an object full, one that no longer holds its object empty.

    NOTE: a robot's own report on its gripper is kept: it may hold an object that is in no fact.
    """
    told = {f.args[0] for f in news if f.predicate == ROBOT_ATTRIBUTE and f.args[1] == GRIPPER}
    holding = holders(facts[OBJECT_POSITION])
    result = set(facts[ROBOT_ATTRIBUTE])
    for robot in _robots_in(facts):
        full, empty = (Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, value)) for value in (FULL, EMPTY))
        if robot in holding:
            result.discard(empty)
            result.add(full)
        elif robot in held_before and robot not in told:
            result.discard(full)
            result.add(empty)
    return result
