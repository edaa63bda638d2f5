"""Berths: a location with room for several samples is a row of places, each with room for one and its own beacon.

They stand side by side across the first direction that the location is approached from, so that a robot docks at each
as at any other place; a berth of `rack_1` is `rack_1_2`, numbered from the south-west. The distances are our
choice; robots dock at such berths in the simulated world (see docs/decisions/berths.md).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import cos, dist, radians, sin

from robots.world.parts import NARROWEST_PITCH_M, Aisle, Location, Point
from robots.world.walls import WALL_THICKNESS_M, Panel

WIDEST_PITCH_M = 0.7
STEP_M = 0.05
ABREAST_PITCH_M = 0.5
"""The least pitch at which two robots can stand at neighbouring berths at once."""
DOCK_M = 0.34
STAND_M = 0.8
"""Distance in front of a berth of a robot's centre when it docks, and when it stands near the berth."""
ROOM_M: Mapping[float, float] = {0.0: 0.15, DOCK_M: 0.25, STAND_M: 0.42}
"""Clearance required in front of a berth by distance from it: for the sample, for docking, for turning with it."""

WAY_M = 0.35
"""Nothing may stand nearer than this to where a robot stands or docks."""

Rows = Mapping[str, tuple[Location, ...]]


def lay_out(
    locations: Sequence[Location],
    areas: Sequence[Aisle],
    panels: Sequence[Panel],
    reached_by: Callable[[Location], int],
) -> Rows:
    """The places of each location: its berths, or the location itself.

    :param reached_by: how many robots reach a location.
    :raises ValueError: if there is no room for a location's berths; names what is in the way.
    """
    if all(location.capacity <= 1 for location in locations):
        return {location.name: (location,) for location in locations}
    ground = _Ground(locations=locations, areas=areas, panels=panels)
    settled: dict[str, tuple[Location, ...]] = {}
    for location in locations:
        least_m = ABREAST_PITCH_M if reached_by(location) > 1 else NARROWEST_PITCH_M
        settled[location.name] = _settled(location, ground, settled, least_m)
    return settled


def _settled(location: Location, ground: "_Ground", settled: Rows, least_m: float) -> tuple[Location, ...]:
    """The location's row, as wide as there is room for."""
    if location.capacity <= 1:
        return (location,)
    objection = ""
    for pitch_m in _pitches(location, least_m):
        row = _row(location, pitch_m)
        objection = next(ground.objections(location, row, pitch_m, settled, least_m), "")
        if not objection:
            return row
    raise ValueError(
        f"locations.{location.name} has no room for {location.capacity} berths {pitch_m} m apart: {objection}; "
        "change its at, capacity or berth_pitch_m"
    )


def _pitches(location: Location, least_m: float) -> Sequence[float]:
    if location.berth_pitch_m is not None:
        return (location.berth_pitch_m,)
    steps = round((WIDEST_PITCH_M - least_m) / STEP_M)
    return [round(WIDEST_PITCH_M - STEP_M * step, 2) for step in range(steps + 1)]


def _row(location: Location, pitch_m: float) -> tuple[Location, ...]:
    """The berths, side by side around the location; itself if it has room for one."""
    if location.capacity <= 1:
        return (location,)
    first = radians(location.approach_deg[0])
    along = (-sin(first), cos(first))
    way = 1 if along[0] + 1e-6 * along[1] > 0 else -1
    approach = tuple(deg for deg in location.approach_deg if abs(sin(radians(deg) - first)) < 1e-6)
    offsets = [way * pitch_m * (k - (location.capacity - 1) / 2) for k in range(location.capacity)]
    return tuple(
        Location(
            name=f"{location.name}_{number}",
            kind=location.kind,
            at=(round(location.at[0] + off * along[0], 4), round(location.at[1] + off * along[1], 4)),
            approach_deg=approach,
        )
        for number, off in enumerate(offsets, start=1)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Ground:
    """What a row of berths is checked against."""

    locations: Sequence[Location]
    areas: Sequence[Aisle]
    panels: Sequence[Panel]

    def objections(
        self, location: Location, row: Sequence[Location], pitch_m: float, settled: Rows, least_m: float
    ) -> Iterator[str]:
        """The conflicts of a row, in words. Rows that are not settled yet are assumed to have the same pitch."""
        for berth in row:
            words = f"berth {berth.name} at {berth.at}"
            yield from (f"{words} {reason}" for reason in self._out_of_area(location, berth))
            yield from (f"{words} {reason}" for reason in self._at_a_wall(berth))
        for other in self.locations:
            if other is not location:
                places = settled.get(other.name) or _row(other, other.berth_pitch_m or pitch_m)
                yield from _in_the_way(row, places, least_m)

    def _out_of_area(self, location: Location, berth: Location) -> Iterator[str]:
        """A berth is reached by whoever reaches the location, and by nobody else."""
        for area in self.areas:
            if area.contains(location.at) != area.contains(berth.at):
                yield f"lies {'inside' if area.contains(berth.at) else 'outside'} {area.name}"

    def _at_a_wall(self, berth: Location) -> Iterator[str]:
        for ahead_m, room_m in ROOM_M.items():
            for point in _before(berth, ahead_m):
                for panel in self.panels:
                    free_m = panel.distance_m(point) - WALL_THICKNESS_M / 2
                    if free_m < room_m - 1e-6:
                        where = f"{ahead_m} m in front of it" if ahead_m else "at it"
                        yield _cramped(
                            berth, panel, f"{max(0.0, free_m):.2f} m free {where}, {room_m} m is needed"
                        )


def _before(berth: Location, ahead_m: float) -> Iterable[Point]:
    return [
        (berth.at[0] + ahead_m * cos(radians(deg)), berth.at[1] + ahead_m * sin(radians(deg)))
        for deg in berth.approach_deg
    ]


def _cramped(berth: Location, panel: Panel, words: str) -> str:
    hatch = " (each berth needs a hatch of its own, or one hatch wide enough for all)"
    wall = f"the wall {_point(panel.start)} to {_point(panel.end)}"
    return f"is too near to {wall}: {words}{hatch if berth.kind == 'interchange' else ''}"


def _point(point: Point) -> str:
    return f"({point[0]:g}, {point[1]:g})"


def _in_the_way(row: Sequence[Location], places: Sequence[Location], least_m: float) -> Iterator[str]:
    """Berths and other places that are too near to each other, or stand in the approach to the other."""
    for berth in row:
        words = f"berth {berth.name} at {berth.at}"
        for place in places:
            apart_m = dist(berth.at, place.at)
            if apart_m > STAND_M + WAY_M:
                continue
            if place.capacity and apart_m < least_m - 1e-6:
                yield f"{words} is {apart_m:.2f} m from {place.name}, {least_m} m is needed"
            if place.capacity and _is_before(place, berth):
                yield f"{words} is approached over {place.name}"
            if _is_before(berth, place):
                yield f"{words} stands where robots come to {place.name}"


def _is_before(thing: Location, place: Location) -> bool:
    """True if one place stands where robots dock or stand before another."""
    points = (point for ahead_m in (DOCK_M, STAND_M) for point in _before(place, ahead_m))
    return any(dist(point, thing.at) < WAY_M for point in points)
