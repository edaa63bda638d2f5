"""Sample stores of any size: the layout of MACTA §5, fig. 6, continued. Measures are our choice, in metres.

A yard with doors to the south, behind it one store or several, each behind the other. The stores are divided into
aisles side by side; every aisle has its bays along both walls, its robots, and its interchanges with what lies south
of it. Bays, robots and interchanges are distributed over the aisles.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import ceil
from typing import Any

import yaml

from robots.world.berths import WIDEST_PITCH_M
from robots.world.file import WorldFile
from robots.world.parts import PHASE_TAGS, STORE_TAGS

YARD_DEPTH_M = 4.2
AISLE_WIDTH_M = 4.0
BAY_PITCH_M = 1.4
FIRST_BAY_M = 1.6
TO_WALL_M = 0.5
START_FROM_HOME_M = 0.8
DOOR_PITCH_M = 1.0
HOME_PITCH_M = 1.2
HATCH_PITCH_M = 1.2
DOOR_WIDTH_M = 1.2
HATCH_WIDTH_M = 0.4


class StoreShapeError(ValueError):
    """Raised when a store cannot have these numbers; names the number and its valid range."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StoreShape:
    """The numbers of all parts of a world. `compartments` includes the yard; each bay has room for `bay_capacity`
    samples.

    :raises StoreShapeError: if an aisle has no robot, interchange or bay, or a sample has no place.
    """

    aisles: int
    store_robots: int
    yard_robots: int
    interchanges: int
    doors: int
    bays: int
    samples: int
    compartments: int = 2
    bay_capacity: int = 1

    def __post_init__(self) -> None:
        least = {field.name: 1 for field in fields(self)} | {"samples": 0, "compartments": 2}
        least |= dict.fromkeys(("store_robots", "interchanges", "bays"), self.aisles)
        for name, number in least.items():
            if getattr(self, name) < number:
                reason = f": each of the {self.aisles} aisles needs one" if name in _PER_AISLE else ""
                raise StoreShapeError(f"{name.replace('_', ' ')} must be at least {number}{reason}")
        if self.aisles % (self.compartments - 1):
            raise StoreShapeError(
                f"aisles must be a multiple of {self.compartments - 1}, the compartments behind the yard"
            )
        room = self.doors + self.bays * self.bay_capacity
        if self.samples > room:
            each = (
                "one a door and bay" if self.bay_capacity == 1 else f"{self.bay_capacity} a bay, one a door"
            )
            raise StoreShapeError(f"samples must be at most {room}, {each}; add bays or doors")

    @property
    def columns(self) -> int:
        """The aisles side by side."""
        return self.aisles // (self.compartments - 1)


_PER_AISLE = ("store_robots", "interchanges", "bays")


def store_shape(*, samples: int = 4, compartments: int = 2, **given: int | None) -> StoreShape:
    """A shape from a few numbers; what is not given, or None, follows from the others: four robots for up to 16
    samples, in proportion beyond, and bays with room for half as many again as samples.

    :raises StoreShapeError: see `StoreShape`.
    """
    stores = max(1, compartments - 1)
    numbers = {name: number for name, number in given.items() if number is not None}
    aisles = numbers.setdefault("aisles", stores * max(2, ceil(samples / 8 / stores)))
    robots = numbers.setdefault("store_robots", aisles)
    yard = numbers.setdefault("yard_robots", ceil(robots / stores))
    numbers.setdefault("interchanges", aisles)
    numbers.setdefault("doors", yard)
    capacity = numbers.setdefault("bay_capacity", 1)
    numbers.setdefault("bays", max(aisles, ceil(max(6 * aisles, ceil(1.5 * samples)) / max(1, capacity))))
    return StoreShape(samples=samples, compartments=compartments, **numbers)


def generate_world(
    shape: StoreShape,
    *,
    seed: int = 0,
    name: str = "generated_store",
    in_phases: bool = False,
    shared_chargers: bool = False,
) -> WorldFile:
    """The world of a shape. The seed decides where the samples lie: same shape and seed, same world.

    :param in_phases: its robots drive in phases, and hold a place only while they use it.
    :param shared_chargers: the robots of an area share a charger in place of homes.
    """
    plan = _Plan(shape)
    places = [*plan.doors(), *plan.interchanges(), *plan.bays()]
    storing = [place for place in places if place["kind"] in ("door", "bay")]
    free = [place["name"] for place in storing for _ in range(place.get("capacity", 1))]
    lying = random.Random(seed).sample(free, shape.samples)
    stationed = [*plan.yard_robots(), *plan.store_robots()]
    robots = [robot for _, robot in stationed]
    charging = [home for home, _ in stationed]
    if shared_chargers:
        charging = list(_chargers(stationed))
        robots = [robot | {"home": None} for robot in robots]
    repertoire = {"repertoire": (*STORE_TAGS, *PHASE_TAGS)} if in_phases else {}
    return WorldFile.model_validate(
        {
            "name": name,
            "title": f"Sample store of {shape.aisles} aisles and {len(robots)} robots",
            "compartments": plan.compartments(),
            "walls": plan.walls(),
            "locations": [*places, *charging],
            "robots": [robot | repertoire for robot in robots],
            "samples": [{"name": f"sample_{n}", "at": at} for n, at in enumerate(lying, start=1)],
        }
    )


def world_yaml(world: WorldFile) -> str:
    """The world as the text of a world file, one part per line."""
    lines: list[str] = []
    for key, value in world.model_dump(mode="json", exclude_defaults=True).items():
        if isinstance(value, list):
            lines += [f"{key}:", *(f"  - {_flow(part)}" for part in value)]
        else:
            lines.append(yaml.safe_dump({key: value}, default_flow_style=False, width=1000).strip())
    return "\n".join(lines) + "\n"


def _flow(part: dict[str, Any]) -> str:
    return (
        yaml.safe_dump(part, sort_keys=False, default_flow_style=True, width=100)
        .strip()
        .replace("\n", "\n   ")
    )


Entry = dict[str, Any]


class _Plan:
    """The floor plan of a shape: x to the east, y to the north, the yard's south-west corner at (0, 0)."""

    def __init__(self, shape: StoreShape) -> None:
        self._shape = shape
        self._hatches = self._dealt("interchange", shape.interchanges)
        self._bays = self._dealt("bay", shape.bays)
        self._robots = self._dealt("store", shape.store_robots)
        robots = len(self._robots[0])
        self._width = max(
            AISLE_WIDTH_M,
            HATCH_PITCH_M * (len(self._hatches[0]) + 1),
            HOME_PITCH_M * (robots + 1),
            DOOR_PITCH_M * shape.doors / shape.columns,
            HOME_PITCH_M * shape.yard_robots / shape.columns,
        )
        deep = shape.compartments > 2
        # Robots at home stand clear of the bays, and of the interchanges in a wall behind them.
        self._home_to_wall = TO_WALL_M + (BAY_PITCH_M if deep else 0.0)
        last_bay_to_wall = 1.0 if robots == 1 and not deep else self._home_to_wall + 1.9
        rows = ceil(len(self._bays[0]) / 2)
        self._bay_pitch = max(BAY_PITCH_M, WIDEST_PITCH_M * shape.bay_capacity)
        self._bay_length = WIDEST_PITCH_M * (shape.bay_capacity - 1)
        self._depth = FIRST_BAY_M + self._bay_pitch * (rows - 1) + self._bay_length + last_bay_to_wall

    def _dealt(self, word: str, count: int) -> list[list[str]]:
        """Numbered names distributed over the aisles, consecutive ones in the same aisle."""
        each, more = divmod(count, self._shape.aisles)
        names = iter([f"{word}_{number}" for number in range(1, count + 1)])
        return [[next(names) for _ in range(each + (k < more))] for k in range(self._shape.aisles)]

    @property
    def _across(self) -> float:
        return self._width * self._shape.columns

    def _corner(self, aisle: int) -> tuple[float, float]:
        """The south-west corner of an aisle."""
        store, column = divmod(aisle, self._shape.columns)
        return self._width * column, YARD_DEPTH_M + self._depth * store

    def _store(self, aisle: int) -> str:
        store = aisle // self._shape.columns
        return "store" if self._shape.compartments == 2 else f"compartment_{store + 2}"

    def compartments(self) -> Iterator[Entry]:
        yield _area("yard", 0, self._across, 0, YARD_DEPTH_M)
        columns = self._shape.columns
        for first in range(0, self._shape.aisles, columns):
            south = self._corner(first)[1]
            aisles = [
                _area(f"aisle_{k + 1}", x, x + self._width, south, south + self._depth)
                for k in range(first, first + columns)
                for x, _ in (self._corner(k),)
            ]
            yield _area(self._store(first), 0, self._across, south, south + self._depth) | {"aisles": aisles}

    def walls(self) -> Iterator[Entry]:
        north = YARD_DEPTH_M + self._depth * (self._shape.compartments - 1)
        pitch = self._across / self._shape.doors
        width = min(DOOR_WIDTH_M, 0.8 * pitch)
        yield _wall((0, 0), (self._across, 0), "door", [door["at"][0] for door in self.doors()], width)
        for x in (0.0, self._across):
            yield _wall((x, 0), (x, north))
        yield _wall((0, north), (self._across, north))
        for first in range(0, self._shape.aisles, self._shape.columns):
            y = self._corner(first)[1]
            hatches = [hatch["at"][0] for hatch in self.interchanges() if hatch["at"][1] == _cm(y)]
            yield _wall((0, y), (self._across, y), "hatch", hatches, HATCH_WIDTH_M)
        for column in range(1, self._shape.columns):
            x = self._width * column
            yield _wall((x, YARD_DEPTH_M), (x, north))

    def doors(self) -> Iterator[Entry]:
        for number, x in enumerate(_spread(0, self._across, self._shape.doors), start=1):
            yield _place(f"door_{number}", "door", x, 0.4, [90])

    def interchanges(self) -> Iterator[Entry]:
        for aisle, names in enumerate(self._hatches):
            west, south = self._corner(aisle)
            for name, x in zip(names, _spread(west, west + self._width, len(names)), strict=True):
                yield _place(name, "interchange", x, south, [90, -90])

    def bays(self) -> Iterator[Entry]:
        for aisle, names in enumerate(self._bays):
            west, south = self._corner(aisle)
            rows = ceil(len(names) / 2)
            for number, name in enumerate(names):
                y = south + FIRST_BAY_M + self._bay_length / 2 + self._bay_pitch * (number % rows)
                at_west = number < rows
                x = west + (TO_WALL_M if at_west else self._width - TO_WALL_M)
                bay = _place(name, "bay", x, y, [0 if at_west else 180])
                yield bay if self._shape.bay_capacity == 1 else bay | {"capacity": self._shape.bay_capacity}

    def yard_robots(self) -> Iterator[tuple[Entry, Entry]]:
        middle = YARD_DEPTH_M / 2
        half = START_FROM_HOME_M / 2
        for number, x in enumerate(_spread(0, self._across, self._shape.yard_robots), start=1):
            robot = {"name": f"yard_{number}", "compartment": "yard"}
            yield _at_home(robot, (x - half, middle), (x + half, middle), 0)

    def store_robots(self) -> Iterator[tuple[Entry, Entry]]:
        for aisle, names in enumerate(self._robots):
            west, south = self._corner(aisle)
            y = south + self._depth - self._home_to_wall
            for name, x in zip(names, _spread(west, west + self._width, len(names)), strict=True):
                robot = {"name": name, "compartment": self._store(aisle), "aisle": f"aisle_{aisle + 1}"}
                yield _at_home(robot, (x, y), (x, y - START_FROM_HOME_M), -90)


Point = tuple[float, float]


def _at_home(robot: Entry, home: Point, start: Point, approach_deg: int) -> tuple[Entry, Entry]:
    """The home and its robot, which faces as the home's beacon does."""
    place = _place(f"home_{robot['name']}", "home", *home, [approach_deg]) | {"capacity": 0}
    return place, robot | {"start": [_cm(start[0]), _cm(start[1]), approach_deg], "home": place["name"]}


def _chargers(stationed: Sequence[tuple[Entry, Entry]]) -> Iterator[Entry]:
    """One for the robots of each area, where the first of them has its home."""
    served = set()
    for home, robot in stationed:
        area = robot.get("aisle", robot["compartment"])
        if area not in served:
            served.add(area)
            yield home | {"name": f"charger_{area}", "kind": "charger"}


def _spread(low: float, high: float, count: int) -> list[float]:
    """The middles of `count` equal parts of an interval."""
    return [low + (high - low) * (part + 0.5) / count for part in range(count)]


def _cm(value: float) -> float:
    return round(value, 2)


def _area(name: str, west: float, east: float, south: float, north: float) -> Entry:
    return {"name": name, "x": [_cm(west), _cm(east)], "y": [_cm(south), _cm(north)]}


def _place(name: str, kind: str, x: float, y: float, approach_deg: Sequence[int]) -> Entry:
    return {"name": name, "kind": kind, "at": [_cm(x), _cm(y)], "approach_deg": approach_deg}


def _wall(start: Point, end: Point, kind: str = "", at: Sequence[float] = (), width_m: float = 0.0) -> Entry:
    openings = [{"kind": kind, "at_m": _cm(x), "width_m": _cm(width_m)} for x in at]
    return {"start": [_cm(v) for v in start], "end": [_cm(v) for v in end], "openings": openings}
