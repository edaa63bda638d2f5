"""Zones for one robot at a time: which places lie in them, and which ways enter, leave or cross them."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import cos, radians, sin

from app.domain.world_model.beliefs import OBJECT_POSITION, ROBOT_POSITION, ZONE_CLEAR
from planner import Crossing, Fact, PlanNet, PlanNetAction
from robots.physical.stand_off import STAND_OFF_M
from robots.world import Location, WorldFile, Zone, ZoneRule
from robots.world.file import ROBOT_WIDTH_M
from robots.world.parts import Aisle, Rectangle
from robots.world.slopes import within

Point = tuple[float, float]
Spot = str
"""The location that stands for where a robot is on the open floor."""


def places_in_zones(world: WorldFile) -> Iterator[tuple[str, str, str]]:
    """Place, area and zone, where a robot of the area that stands at the place is in the zone."""
    zones = world.zones_of(ZoneRule.ONE_ROBOT)
    areas = [(area.name, stands_in(area, world)) for area in _areas(world)] if zones else []
    for zone in zones:
        claimed = _claimed(zone)
        for area, places in areas:
            for place, stands in places.items():
                if _has_any(claimed, stands):
                    yield place, area, zone.name


def crossings(
    world: WorldFile, spots: Mapping[Spot, Point], ways: Mapping[str, set[str]]
) -> dict[tuple[str, str], tuple[Crossing, ...]]:
    """The zones for one robot that each straight way enters or leaves.

    :param spots: where robots stand on the open floor, x and y in metres.
    :param ways: for each place or spot those that some robot can drive to from there.
    """
    zones = [(zone.name, _claimed(zone)) for zone in world.zones_of(ZoneRule.ONE_ROBOT)]
    found: dict[tuple[str, str], dict[str, Crossing]] = {}
    for area in _areas(world) if zones else ():
        stands = {**stands_in(area, world), **{spot: (point,) for spot, point in spots.items()}}
        for name, zone in zones:
            inside = {place: _has_any(zone, points) for place, points in stands.items()}
            beyond = {place: _beyond(zone, points) for place, points in stands.items()}
            for start in stands.keys() & ways.keys():
                for end in stands.keys() & ways[start]:
                    if start == end or beyond[start] & beyond[end]:
                        continue
                    if inside[start] or inside[end]:
                        crosses = inside[start] != inside[end]
                    else:
                        pairs = product(stands[start], stands[end])
                        crosses = any(within(one, other, zone) is not None for one, other in pairs)
                    if crosses:
                        crossing = Crossing(zone=name, enters=not inside[start], leaves=not inside[end])
                        found.setdefault((start, end), {}).setdefault(name, crossing)
    return {way: tuple(crossed.values()) for way, crossed in sorted(found.items())}


def restricted_places(world: WorldFile) -> dict[str, str]:
    """Place that is in a zone to keep out of, or for one robot → the zone."""
    return {place: zone for place, _, zone in places_in_zones(world)} | dict(world.kept_out)


def zones_against(plan_net: PlanNet, world: WorldFile) -> Iterator[str]:
    """The zones of the world that the plan-net does not keep to, in words: it was made before they were."""
    used = {place: action for action in plan_net.actions for place in _aims(action)}
    for place in sorted(used.keys() & world.kept_out.keys()):
        yield f"{used[place].id} goes to {place}, which is in {world.kept_out[place]}, a zone to keep out of"
    if not world.zones_of(ZoneRule.ONE_ROBOT):
        return
    moves = [(action, start, end) for action in plan_net.actions for start, end in _moves(action)]
    ways: dict[str, set[str]] = defaultdict(set)
    for _, start, end in moves:
        ways[start].add(end)
    crossed = crossings(world, {}, {**ways, **{end: set() for _, _, end in moves if end not in ways}})
    for action, start, end in moves:
        for one in crossed.get((start, end), ()):
            clear = Fact(ZONE_CLEAR, (one.zone,))
            if one.enters and clear not in action.preconditions:
                yield f"{action.id} enters {one.zone}, a zone for one robot, without regard to others"


def _aims(action: PlanNetAction) -> Iterator[str]:
    return (fact.args[2] for fact in action.effects if fact.predicate in (ROBOT_POSITION, OBJECT_POSITION))


def _moves(action: PlanNetAction) -> Iterator[tuple[str, str]]:
    """From where to where the action takes its robots."""
    before = {fact.args[0]: fact.args[2] for fact in action.deletes if fact.predicate == ROBOT_POSITION}
    after = {fact.args[0]: fact.args[2] for fact in action.effects if fact.predicate == ROBOT_POSITION}
    return ((before[robot], after[robot]) for robot in before.keys() & after.keys())


def spots_in_zones(world: WorldFile, spots: Mapping[Spot, Point]) -> Iterator[tuple[Spot, str]]:
    """The spots on the open floor that lie in a zone for one robot, and the zone."""
    for zone in world.zones_of(ZoneRule.ONE_ROBOT):
        yield from ((spot, zone.name) for spot, point in spots.items() if _claimed(zone).contains(point))


def _claimed(zone: Zone) -> Rectangle:
    """The zone, and where the middle of a robot is whose hull is in it."""
    return zone.grown(ROBOT_WIDTH_M / 2)


def _areas(world: WorldFile) -> list[Aisle]:
    return list({area.name: area for area in map(world.area_of, world.robots)}.values())


def stands_in(area: Aisle, world: WorldFile) -> dict[str, tuple[Point, ...]]:
    """Where robots of the area stand at its places: before each beacon, and at it."""
    return {place.name: _stands(place, area) for place in world.places if area.contains(place.at)}


def _stands(place: Location, area: Aisle) -> tuple[Point, ...]:
    x, y = place.at
    axes = [radians(axis) for axis in place.approach_deg]
    before = [(x + STAND_OFF_M * cos(axis), y + STAND_OFF_M * sin(axis)) for axis in axes]
    return (place.at, *(point for point in before if area.contains(point)))


def _beyond(zone: Rectangle, points: Sequence[Point]) -> int:
    """The sides of the zone beyond which all the points lie, a bit each: a way between two such sides passes by."""
    (left, right), (low, high) = zone.x, zone.y
    sides = (
        all(x < left for x, _ in points),
        all(x > right for x, _ in points),
        all(y < low for _, y in points),
        all(y > high for _, y in points),
    )
    return sum(1 << side for side, is_beyond in enumerate(sides) if is_beyond)


def _has_any(zone: Rectangle, points: Sequence[Point]) -> bool:
    return any(zone.contains(point) for point in points)
