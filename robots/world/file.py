"""The world file: compartments, walls, locations, robots and samples (metres, degrees where the name says so).

World frame: x to the east, y to the north, headings counter-clockwise from east.
"""

from collections import Counter
from collections.abc import Iterable
from itertools import combinations
from math import dist, hypot
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
Point = tuple[float, float]
Interval = tuple[float, float]

PACKET_TAGS = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK")
ON_BORDER_M = 0.05
ROBOT_WIDTH_M = 0.44


class Part(BaseModel):
    """Base of every part of a world file: immutable, unknown keys are an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Aisle(Part):
    """An allocated area of a compartment, x and y intervals in metres."""

    name: Name
    x: Interval
    y: Interval

    def contains(self, point: Point) -> bool:
        """True inside or on the border, so that an interchange in a wall belongs to both sides."""
        inside = (
            low - ON_BORDER_M <= value <= high + ON_BORDER_M
            for value, (low, high) in zip(point, (self.x, self.y), strict=True)
        )
        return all(inside)


class Compartment(Aisle):
    """A rectangle of floor, divided into aisles or not."""

    aisles: tuple[Aisle, ...] = ()


class Opening(Part):
    """A gap in a wall, `at_m` metres from the wall's start to the gap's middle.

    door: closed to robots, samples are brought in from outside; hatch: narrow, samples pass, robots do not;
    gap: robots pass.
    """

    kind: Literal["door", "hatch", "gap"]
    at_m: float = Field(ge=0)
    width_m: float = Field(gt=0)


class Wall(Part):
    """A straight wall between two points."""

    start: Point
    end: Point
    openings: tuple[Opening, ...] = ()

    @property
    def length_m(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])


class Location(Part):
    """A named place on the floor with an infra-red beacon above it.

    `approach_deg` are the directions in which the beacon emits: a robot docks from there. `capacity` is how many
    samples may lie there (a home has 0).
    """

    name: Name
    kind: Literal["door", "interchange", "bay", "home", "lander", "place"]
    at: Point
    approach_deg: tuple[float, ...] = Field(min_length=1)
    capacity: int = Field(default=1, ge=0, le=1)


class RobotSpec(Part):
    """A robot of the team: start is x, y in metres and heading in degrees."""

    name: Name
    compartment: Name
    aisle: Name | None = None
    start: tuple[float, float, float]
    home: Name | None = None
    body: Literal["velocity"] = "velocity"
    repertoire: tuple[Literal["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK"], ...] = (
        PACKET_TAGS  # type: ignore[assignment]
    )
    speed_m_s: float = Field(default=0.5, gt=0, le=2)
    turn_rad_s: float = Field(default=1.5, gt=0, le=6)
    whiskers: int = Field(default=16, ge=8, le=64)
    whisker_range_m: float = Field(default=2.5, gt=0.2, le=10)


class Sample(Part):
    """A tagged sample and where it lies at the start."""

    name: Name
    at: Name


class WorldFact(Part):
    """An extra initial fact, in rel/ref form."""

    predicate: str
    args: tuple[str, ...] = ()


class WorldFile(Part):
    """A whole world. Every name is unique in the file; every reference resolves."""

    name: Name
    title: str = ""
    compartments: tuple[Compartment, ...] = Field(min_length=1)
    walls: tuple[Wall, ...] = ()
    locations: tuple[Location, ...] = Field(min_length=1)
    robots: tuple[RobotSpec, ...] = Field(min_length=1)
    samples: tuple[Sample, ...] = ()
    facts: tuple[WorldFact, ...] = ()

    def location(self, name: str) -> Location:
        return next(location for location in self.locations if location.name == name)

    def robot(self, name: str) -> RobotSpec:
        return next(robot for robot in self.robots if robot.name == name)

    def area_of(self, robot: RobotSpec) -> Aisle:
        """The robot's allocated area: its aisle, else its whole compartment."""
        compartment = next(c for c in self.compartments if c.name == robot.compartment)
        return next((a for a in compartment.aisles if a.name == robot.aisle), compartment)

    def reach_of(self, robot: RobotSpec) -> tuple[Location, ...]:
        """The locations inside or on the border of the robot's area; of the homes only its own."""
        area = self.area_of(robot)
        return tuple(
            place
            for place in self.locations
            if area.contains(place.at) and (place.kind != "home" or place.name == robot.home)
        )

    @model_validator(mode="after")
    def _check(self) -> Self:
        aisles = [aisle for compartment in self.compartments for aisle in compartment.aisles]
        parts = (self.compartments, aisles, self.locations, self.robots, self.samples)
        _unique([part.name for group in parts for part in group])
        places = {place.name: place for place in self.locations}
        for robot in self.robots:
            self._check_robot(robot, places)
        for one, other in combinations(self.robots, 2):
            if dist(one.start[:2], other.start[:2]) < ROBOT_WIDTH_M:
                raise ValueError(f"robots.{one.name} and robots.{other.name} start in the same place")
        for sample in self.samples:
            _known("location", sample.at, places, f"samples.{sample.name}.at")
            self._check_lies(sample)
        for name, count in Counter(sample.at for sample in self.samples).items():
            if count > places[name].capacity:
                raise ValueError(f"{name} has room for {places[name].capacity} samples, {count} start there")
        for place in self.locations:
            if not any(compartment.contains(place.at) for compartment in self.compartments):
                raise ValueError(f"locations.{place.name} at {place.at} lies in no compartment")
        for wall in self.walls:
            for opening in wall.openings:
                if opening.at_m + opening.width_m / 2 > wall.length_m:
                    raise ValueError(
                        f"{opening.kind} at {opening.at_m} m is beyond its wall's {wall.length_m:.2f} m"
                    )
        return self

    def _check_lies(self, sample: Sample) -> None:
        """No fact of the file lays the sample elsewhere, or says that nothing lies where it does."""
        elsewhere = {(sample.name, place.name) for place in self.locations if place.name != sample.at}
        for fact in self.facts:
            laid_elsewhere = fact.predicate == "in" and fact.args in elsewhere
            if laid_elsewhere or (fact.predicate == "vacant" and fact.args == (sample.at,)):
                stated = f"{fact.predicate}({', '.join(fact.args)})"
                raise ValueError(f"samples.{sample.name}.at is {sample.at}, but the facts say {stated}")

    def _check_robot(self, robot: RobotSpec, places: dict[str, Location]) -> None:
        compartments = {c.name: c for c in self.compartments}
        _known("compartment", robot.compartment, compartments, f"robots.{robot.name}.compartment")
        if robot.aisle is not None:
            aisles = {a.name: a for a in compartments[robot.compartment].aisles}
            _known("aisle", robot.aisle, aisles, f"robots.{robot.name}.aisle")
        if robot.home is not None:
            _known("location", robot.home, places, f"robots.{robot.name}.home")
        area = self.area_of(robot)
        if not area.contains(robot.start[:2]):
            raise ValueError(f"robots.{robot.name} starts at {robot.start[:2]}, outside its area {area.name}")


def _unique(names: list[str]) -> None:
    doubles = sorted(name for name, count in Counter(names).items() if count > 1)
    if doubles:
        raise ValueError(f"names must be unique in a world; used twice: {', '.join(doubles)}")


def _known(what: str, name: str, choices: Iterable[str], where: str) -> None:
    if name not in choices:
        raise ValueError(f"{where}: unknown {what} {name!r}; choices: {', '.join(sorted(choices))}")
