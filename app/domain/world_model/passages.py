"""Doors, hatches and lifts: which ways lead through them, and what these ask for.

In a world with doors or lifts, walls count: a straight way that leads through one is none, and plans lead from place to
place through the doorways. Worlds without any are planned as before.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from math import hypot

from app.domain.world_model.beliefs import CLOSED, LIFT_AT, ON_WAY, OPENED, OPERABLE, VACANT
from app.domain.world_model.zones import stands_in
from planner import Access, Crossing, Fact
from robots.world import Peripheral, PeripheralKind, WorldFile
from robots.world.file import ROBOT_WIDTH_M
from robots.world.peripherals import lies_in
from robots.world.walls import Panel, panels_of

Point = tuple[float, float]
Way = tuple[str, str]
CLEARANCE_M = ROBOT_WIDTH_M / 2 + 0.03
"""From a robot's middle to a wall that it drives past."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Passages:
    """What doors, hatches and lifts mean for ways.

    :param walled: the ways that lead through a wall.
    :param crossings: doorways for one robot, by way.
    """

    walled: frozenset[Way] = frozenset()
    access: Access = field(default_factory=Access)
    crossings: Mapping[Way, tuple[Crossing, ...]] = field(default_factory=dict)


def passages(world: WorldFile, spots: Mapping[str, Point], ways: Mapping[str, set[str]]) -> Passages:
    """What the world's peripherals mean for these ways.

    :param spots: where robots stand on the open floor, metres.
    :param ways: for each place or spot those that some robot can drive to from there.
    """
    if not world.peripherals:
        return Passages()
    walled: set[Way] = set()
    asked: dict[Way, tuple[Fact, ...]] = {}
    crossings: dict[Way, tuple[Crossing, ...]] = {}
    doors = [one for one in world.peripherals if one.kind is not PeripheralKind.HATCH]
    if doors:
        panels = panels_of(world.walls)
        stands = {**_stands(world), **{spot: (point,) for spot, point in spots.items()}}
        for start in sorted(stands.keys() & ways.keys()):
            for end in sorted(stands.keys() & ways[start]):
                if start == end:
                    continue
                free = [
                    pair
                    for pair in product(stands[start], stands[end])
                    if _is_free(*pair, panels) and not any(_rides(one, *pair) for one in doors)
                ]
                if not free:
                    walled.add((start, end))
                    continue
                through = [one for one in doors if any(_crossed(one, *pair) for pair in free)]
                facts = tuple(
                    _needed(one, panel)
                    for one in through
                    for panel in dict.fromkeys(p for pair in free for p in _crossed(one, *pair))
                )
                if facts:
                    asked[start, end] = facts
                if narrow := [one.passage for one in through if one.passage]:
                    crossings[start, end] = tuple(
                        Crossing(zone=zone, enters=True, leaves=True) for zone in narrow
                    )
    return Passages(
        walled=frozenset(walled),
        access=Access(
            ways=asked, positions=_positions(world), to_end=_to_end(world), restored=_restored(world)
        ),
        crossings=crossings,
    )


def state_fact(peripheral: Peripheral, state: str) -> Fact:
    """What a state says: `open` or `closed`, of a lift the level."""
    if peripheral.is_lift:
        return Fact(LIFT_AT, (peripheral.name, state))
    return Fact(OPENED if state == "open" else CLOSED, (peripheral.name,))


def facts_of_peripherals(world: WorldFile) -> Iterator[Fact]:
    """What holds of the peripherals at the start."""
    for one in world.peripherals:
        yield state_fact(one, one.state_at_start)
        yield Fact(OPERABLE, (one.name,))
    if any(one.kind is not PeripheralKind.HATCH for one in world.peripherals):
        yield from (Fact(ON_WAY, (place.name,)) for place in world.places if place.kind == "place")


def unheld(world: WorldFile) -> frozenset[Fact]:
    """What a plan must not rest on: a door that closes by itself does not stay open."""
    return frozenset(
        Fact(OPENED, (one.name,)) for one in world.peripherals if not one.is_lift and one.normally == "closed"
    )


def functions_of(world: WorldFile) -> dict[tuple[str, tuple[str, ...]], float]:
    """How long the peripherals' actions take, seconds."""
    found: dict[tuple[str, tuple[str, ...]], float] = {}
    for one in world.peripherals:
        if one.is_lift:
            ride_s = one.closing_s + one.travel_s + one.opening_s
            pairs = product(one.levels, repeat=2)
            found |= {("travel_s", (one.name, low, high)): ride_s for low, high in pairs if low != high}
        else:
            found["opening_s", (one.name,)] = one.opening_s
            found["closing_s", (one.name,)] = one.closing_s
    return found


def _needed(peripheral: Peripheral, panel: Panel) -> Fact:
    if peripheral.is_lift:
        level = next(stop.level for stop in peripheral.stops if stop.panel == panel)
        return state_fact(peripheral, level)
    return state_fact(peripheral, "open")


def _positions(world: WorldFile) -> dict[tuple[str, ...], tuple[Fact, ...]]:
    """Samples that lie in a hatch, and robots that hold one there, ask that it be open."""
    return {
        (relation, place.name): (state_fact(one, "open"),)
        for one in world.peripherals
        if one.kind is PeripheralKind.HATCH
        for place in world.places
        if lies_in(place, one)
        for relation in ("in", "at")
    }


def _to_end(world: WorldFile) -> dict[Fact, tuple[Fact, ...]]:
    """A hatch is closed only once nothing lies in it."""
    return {
        state_fact(one, "open"): tuple(
            Fact(VACANT, (place.name,)) for place in world.places if place.capacity and lies_in(place, one)
        )
        for one in world.peripherals
        if one.kind is PeripheralKind.HATCH
    }


def _restored(world: WorldFile) -> frozenset[Fact]:
    return frozenset(state_fact(one, one.normally) for one in world.peripherals if not one.is_lift)


def _stands(world: WorldFile) -> dict[str, tuple[Point, ...]]:
    """Where robots stand that are near a place: before its beacon, within their areas."""
    found: dict[str, tuple[Point, ...]] = {}
    for area in {area.name: area for area in map(world.area_of, world.robots)}.values():
        for place, (at, *before) in stands_in(area, world).items():
            found[place] = (*found.get(place, ()), *(before or [at]))
    return found


def _is_free(one: Point, other: Point, panels: tuple[Panel, ...]) -> bool:
    """True if a robot can drive straight from one to the other; it may begin or end nearer to a wall."""
    return all(
        _gap_m(one, other, panel) >= min(CLEARANCE_M, panel.distance_m(one), panel.distance_m(other)) - 1e-6
        for panel in panels
        if not _crosses(one, other, panel)
    ) and not any(_crosses(one, other, panel) for panel in panels)


def _crossed(peripheral: Peripheral, one: Point, other: Point) -> tuple[Panel, ...]:
    return tuple(panel for panel in peripheral.panels if _crosses(one, other, panel))


def _rides(peripheral: Peripheral, one: Point, other: Point) -> bool:
    """True if the way leads through a lift from level to level: robots stop in its cabin."""
    return len(_crossed(peripheral, one, other)) > 1


def _gap_m(one: Point, other: Point, panel: Panel) -> float:
    """The least distance between two segments that do not cross: at an end of one of them."""
    way = Panel(start=one, end=other)
    if way.length_m < 1e-9:
        return panel.distance_m(one)
    return min(
        panel.distance_m(one),
        panel.distance_m(other),
        way.distance_m(panel.start),
        way.distance_m(panel.end),
    )


def _crosses(one: Point, other: Point, panel: Panel) -> bool:
    """True if the way meets the panel's middle line."""
    sides = [_side(panel.start, panel.end, point) for point in (one, other)]
    ends = [_side(one, other, point) for point in (panel.start, panel.end)]
    if hypot(other[0] - one[0], other[1] - one[1]) < 1e-9:
        return False
    return sides[0] * sides[1] <= 0 and ends[0] * ends[1] <= 0


def _side(start: Point, end: Point, point: Point) -> float:
    """Positive to the left of the line."""
    return (end[0] - start[0]) * (point[1] - start[1]) - (end[1] - start[1]) * (point[0] - start[0])
