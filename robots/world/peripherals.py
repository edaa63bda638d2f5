"""Doors, hatches and lifts of a world file: what moves in a building and does not drive.

Metres and seconds, world frame. A door or hatch is a straight panel that is there while it is closed. A lift is, in
the plane, a cabin with a door a level: the door of the level at which it stands is open, the others are closed.
"""

from collections.abc import Iterable, Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator
from typing_extensions import Self

from robots.data import Checked, StrEnum
from robots.world.parts import Interval, Location, Name, Point, Wall
from robots.world.walls import WALL_THICKNESS_M, Panel, panels_of

Seconds = Annotated[float, Field(gt=0, le=600)]
STANDS_CLEAR_M = 0.3
"""A robot that stands at a place must be at least this far from a door's panel, or it would keep the door open."""
DOOR_TAGS = ("OPEN", "CLOSE")
LIFT_TAGS = ("MOVE_TO_LEVEL",)
PERIPHERAL_TAGS = (*DOOR_TAGS, *LIFT_TAGS)
"""The packets of peripherals; no robot has them, and no repertoire."""


class PeripheralKind(StrEnum):
    """What a peripheral is."""

    DOOR = "door"
    """Robots pass through it."""
    HATCH = "hatch"
    """Samples pass through it, in robots' jaws: whatever is put or taken at a place in it asks that it be open."""
    LIFT = "lift"
    """Robots drive into its cabin at one level and out at another."""


class Stop(Checked):
    """A level at which a lift stops, and the door of its cabin there."""

    level: Name
    start: Point
    end: Point

    @property
    def panel(self) -> Panel:
        return Panel(start=self.start, end=self.end, door=True)


class Cabin(Checked):
    """The floor of a lift's cabin."""

    x: Interval
    y: Interval

    def contains(self, point: Point) -> bool:
        """True inside or on the border."""
        return self.x[0] <= point[0] <= self.x[1] and self.y[0] <= point[1] <= self.y[1]


class Peripheral(Checked):
    """A door, hatch or lift. It is an agent: scripts command it, and it reports.

    A door or hatch has its panel from `start` to `end`. `capacity`: robots in the doorway at once, 1 or any number
    (null). `opening_s`, `closing_s`: how long its panel moves. `normally`: how it is left when nobody needs it; one
    that is normally closed closes by itself `stays_open_s` after its last order.
    A lift has a `cabin` and `stops`, two or more; it begins at the first. `travel_s`: between two levels, its doors not
    counted. Its cabin takes one robot for each place in it.
    `external`: software of its own speaks for it on the link; it is not simulated.
    """

    name: Name
    kind: PeripheralKind
    start: Point | None = None
    end: Point | None = None
    cabin: Cabin | None = None
    stops: tuple[Stop, ...] = ()
    opening_s: Seconds = 3.0
    closing_s: Seconds = 3.0
    travel_s: Seconds = 10.0
    stays_open_s: Seconds = 10.0
    capacity: Literal[1] | None = 1
    normally: Literal["open", "closed"] = "closed"
    external: bool = False

    @property
    def is_lift(self) -> bool:
        return self.kind is PeripheralKind.LIFT

    @property
    def panels(self) -> tuple[Panel, ...]:
        """Its panels, as they stand while they are closed: one, or those of a lift's stops in their order."""
        if self.start is not None and self.end is not None:
            return (Panel(start=self.start, end=self.end, door=True),)
        return tuple(stop.panel for stop in self.stops)

    @property
    def centre(self) -> Point:
        """The middle of its panel or cabin."""
        if self.cabin is not None:
            return (sum(self.cabin.x) / 2, sum(self.cabin.y) / 2)
        (panel,) = self.panels
        return ((panel.start[0] + panel.end[0]) / 2, (panel.start[1] + panel.end[1]) / 2)

    @property
    def repertoire(self) -> tuple[str, ...]:
        return LIFT_TAGS if self.is_lift else DOOR_TAGS

    @property
    def passage(self) -> str:
        """The doorway as a zone for one robot; empty if any number may be in it, and for lifts."""
        is_narrow = self.kind is PeripheralKind.DOOR and self.capacity == 1
        return f"{self.name}_passage" if is_narrow else ""

    @property
    def levels(self) -> tuple[str, ...]:
        return tuple(stop.level for stop in self.stops)

    @property
    def state_at_start(self) -> str:
        """`open` or `closed`; of a lift the level."""
        return self.stops[0].level if self.is_lift else self.normally

    @model_validator(mode="after")
    def _has_its_parts(self) -> Self:
        if self.is_lift:
            self._check_lift()
        elif self.start is None or self.end is None:
            raise ValueError(f"{self.name} is a {self.kind}: give its panel a start and an end")
        elif self.cabin is not None or self.stops:
            raise ValueError(f"{self.name} is a {self.kind}: cabin and stops are of lifts only")
        for panel in self.panels:
            if panel.length_m < 2 * WALL_THICKNESS_M:
                raise ValueError(f"{self.name}: a panel is at least {2 * WALL_THICKNESS_M} m wide")
        return self

    def _check_lift(self) -> None:
        if self.start is not None or self.end is not None:
            raise ValueError(f"{self.name} is a lift: give start and end to each of its stops")
        if self.cabin is None or len(self.stops) < 2:
            raise ValueError(f"{self.name} is a lift: it needs a cabin and at least two stops")
        if len(set(self.levels)) < len(self.levels):
            raise ValueError(f"{self.name}: each of its stops has a level of its own")


def faults_of(
    peripherals: Iterable[Peripheral], walls: Iterable[Wall], places: Iterable[Location]
) -> Iterator[str]:
    """What is wrong with where the peripherals are."""
    solid = panels_of(walls)
    stood_at = list(places)
    for one in peripherals:
        where = f"peripherals.{one.name}"
        for panel in one.panels:
            middle = _middle(panel)
            if any(other.distance_m(middle) < WALL_THICKNESS_M / 2 for other in solid):
                opening = "hatch" if one.kind is PeripheralKind.HATCH else "gap"
                yield f"{where} stands in a wall at {_words(middle)}; give the wall a {opening} there"
        if one.kind is PeripheralKind.HATCH:
            if not any(lies_in(place, one) for place in stood_at):
                yield f"{where} has no place in it; give it an interchange, or make it a door"
            continue
        for place in stood_at:
            if any(panel.distance_m(place.at) < STANDS_CLEAR_M for panel in one.panels):
                yield (
                    f"{where}: locations.{place.name} is nearer to it than {STANDS_CLEAR_M} m; who stands there would "
                    "keep it from closing"
                )
        if one.cabin is not None and not any(one.cabin.contains(place.at) for place in stood_at):
            yield f"{where} has no place in its cabin; give it one where a robot can stand"


def lies_in(place: Location, hatch: Peripheral) -> bool:
    """True if what lies at the place lies under the hatch's panel."""
    return any(panel.distance_m(place.at) < WALL_THICKNESS_M for panel in hatch.panels)


def _middle(panel: Panel) -> Point:
    return ((panel.start[0] + panel.end[0]) / 2, (panel.start[1] + panel.end[1]) / 2)


def _words(point: Point) -> str:
    return f"({point[0]:g}, {point[1]:g})"
