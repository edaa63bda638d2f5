"""The world file: its parts checked against each other, and the places that robots know."""

from collections import Counter
from collections.abc import Iterable, Mapping
from functools import cached_property
from itertools import chain, combinations
from math import dist
from typing import Self

from pydantic import Field, ValidationError, model_validator

from robots.data import Checked
from robots.world.berths import lay_out
from robots.world.parts import (
    Aisle,
    Compartment,
    Location,
    Name,
    Obstacle,
    RobotSpec,
    Sample,
    Wall,
    WorldFact,
)
from robots.world.radio import LinkSpec
from robots.world.walls import panels_of

ROBOT_WIDTH_M = 0.44


class WorldFile(Checked):
    """A whole world. Every name is unique in the file; every reference resolves."""

    name: Name
    title: str = ""
    compartments: tuple[Compartment, ...] = Field(min_length=1)
    walls: tuple[Wall, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    locations: tuple[Location, ...] = Field(min_length=1)
    robots: tuple[RobotSpec, ...] = Field(min_length=1)
    samples: tuple[Sample, ...] = ()
    facts: tuple[WorldFact, ...] = ()
    link: LinkSpec = LinkSpec()

    @cached_property
    def rows(self) -> Mapping[str, tuple[Location, ...]]:
        """What the robots know of each location: its berths if it has room for several samples, else itself."""
        areas = [area for compartment in self.compartments for area in (compartment, *compartment.aisles)]
        reaching = [self.area_of(robot) for robot in self.robots]
        return lay_out(
            self.locations,
            areas,
            panels_of(self.walls),
            lambda location: sum(area.contains(location.at) for area in reaching),
        )

    @cached_property
    def places(self) -> tuple[Location, ...]:
        """Where robots go and samples lie, one each at most: the locations, or their berths."""
        return tuple(chain.from_iterable(self.rows.values()))

    @cached_property
    def owners(self) -> Mapping[str, str]:
        """Place → the location that it is, or is a berth of."""
        return {place.name: name for name, row in self.rows.items() for place in row}

    @cached_property
    def lying(self) -> Mapping[str, str]:
        """Sample → the place where it lies at the start: where a location has berths, the first that is free.

        :raises ValueError: if more samples start at a location than it has room for.
        """
        lying = {sample.name: sample.at for sample in self.samples}
        taken = set(lying.values())
        free = {name: iter([p.name for p in row if p.name not in taken]) for name, row in self.rows.items()}
        for sample, at in lying.items():
            if at not in self.owners:
                lying[sample] = next(free[at], at)
        for name, count in Counter(self.owners.get(at, at) for at in lying.values()).items():
            room = sum(place.capacity for place in self.rows[name])
            if count > room:
                raise ValueError(f"{name} has room for {room} samples, {count} start there")
        for place, count in Counter(lying.values()).items():
            if count > 1:
                raise ValueError(f"{place} has room for 1 sample, {count} start there")
        return lying

    def location(self, name: str) -> Location:
        """The location or berth of that name."""
        return next(place for place in (*self.locations, *self.places) if place.name == name)

    def robot(self, name: str) -> RobotSpec:
        return next(robot for robot in self.robots if robot.name == name)

    def link_of(self, robot: RobotSpec) -> LinkSpec:
        """The robot's radio: its own, and where that says nothing the world's."""
        return self.link if robot.link is None else robot.link.over(self.link)

    @property
    def answer_s(self) -> float:
        """`LinkSpec.answer_s` of the robot with the poorest radio."""
        return max(self.link_of(robot).answer_s for robot in self.robots)

    def area_of(self, robot: RobotSpec) -> Aisle:
        """The robot's allocated area: its aisle, else its whole compartment."""
        compartment = next(c for c in self.compartments if c.name == robot.compartment)
        return next((a for a in compartment.aisles if a.name == robot.aisle), compartment)

    def reach_of(self, robot: RobotSpec) -> tuple[Location, ...]:
        """The places inside or on the border of the robot's area; of the homes only its own."""
        area = self.area_of(robot)
        return tuple(
            place
            for place in self.places
            if area.contains(place.at) and (place.kind != "home" or place.name == robot.home)
        )

    @model_validator(mode="after")
    def _check(self) -> Self:
        aisles = [aisle for compartment in self.compartments for aisle in compartment.aisles]
        parts = (self.compartments, aisles, self.obstacles, self.locations, self.robots, self.samples)
        names = [part.name for group in parts for part in group]
        _unique(names)
        self._check_building()
        self._check_obstacles()
        locations = {location.name: location for location in self.locations}
        for robot in self.robots:
            self._check_robot(robot, locations)
        for one, other in combinations(self.robots, 2):
            if dist(one.start[:2], other.start[:2]) < ROBOT_WIDTH_M:
                raise ValueError(f"robots.{one.name} and robots.{other.name} start in the same place")
        _unique([*names, *(place.name for row in self.rows.values() if len(row) > 1 for place in row)])
        for sample in self.samples:
            _known("location", sample.at, {**self.rows, **self.owners}, f"samples.{sample.name}.at")
        for name, place in self.lying.items():
            self._check_lies(name, place)
        return self

    def _check_building(self) -> None:
        for location in self.locations:
            if not any(compartment.contains(location.at) for compartment in self.compartments):
                raise ValueError(f"locations.{location.name} at {location.at} lies in no compartment")
            if location.kind == "home" and location.capacity > 1:
                raise ValueError(f"locations.{location.name}: a home has no berths, capacity must be 0 or 1")
        for wall in self.walls:
            for opening in wall.openings:
                if opening.at_m + opening.width_m / 2 > wall.length_m:
                    raise ValueError(
                        f"{opening.kind} at {opening.at_m} m is beyond its wall's {wall.length_m:.2f} m"
                    )

    def _check_obstacles(self) -> None:
        for obstacle in self.obstacles:
            where = f"obstacles.{obstacle.name} at {obstacle.at}"
            if not any(compartment.contains(obstacle.at) for compartment in self.compartments):
                raise ValueError(f"{where} lies in no compartment")
            reach_m = obstacle.radius_m + obstacle.jitter_m
            for robot in self.robots:
                if dist(robot.start[:2], obstacle.at) < reach_m + ROBOT_WIDTH_M / 2:
                    raise ValueError(f"{where} stands where robots.{robot.name} starts")
            for location in self.locations:
                if dist(location.at, obstacle.at) < reach_m:
                    raise ValueError(f"{where} covers locations.{location.name}")

    def _check_lies(self, sample: str, place: str) -> None:
        """No fact of the file lays the sample elsewhere, or says that nothing lies where it does."""
        here = {place, self.owners[place]}
        elsewhere = {(sample, name) for name in (*self.rows, *self.owners) if name not in here}
        for fact in self.facts:
            laid_elsewhere = fact.predicate == "in" and fact.args in elsewhere
            if laid_elsewhere or (fact.predicate == "vacant" and set(fact.args) <= here):
                stated = f"{fact.predicate}({', '.join(fact.args)})"
                raise ValueError(f"samples.{sample}.at is {place}, but the facts say {stated}")

    def _check_robot(self, robot: RobotSpec, locations: dict[str, Location]) -> None:
        compartments = {c.name: c for c in self.compartments}
        _known("compartment", robot.compartment, compartments, f"robots.{robot.name}.compartment")
        if robot.aisle is not None:
            aisles = {a.name: a for a in compartments[robot.compartment].aisles}
            _known("aisle", robot.aisle, aisles, f"robots.{robot.name}.aisle")
        if robot.home is not None:
            _known("location", robot.home, locations, f"robots.{robot.name}.home")
            if locations[robot.home].capacity > 1:
                raise ValueError(f"robots.{robot.name}.home: {robot.home} has berths, a home has none")
        try:
            self.link_of(robot)
        except ValidationError as error:
            raise ValueError(
                f"robots.{robot.name}.link with the world's: {error.errors()[0]['msg']}"
            ) from error
        area = self.area_of(robot)
        if not area.contains(robot.start[:2]):
            raise ValueError(f"robots.{robot.name} starts at {robot.start[:2]}, outside its area {area.name}")


def _unique(names: list[str]) -> None:
    doubles = sorted(name for name, count in Counter(names).items() if count > 1)
    if doubles:
        raise ValueError(
            f"names must be unique in a world, those of berths too; used twice: {', '.join(doubles)}"
        )


def _known(what: str, name: str, choices: Iterable[str], where: str) -> None:
    if name not in choices:
        raise ValueError(f"{where}: unknown {what} {name!r}; choices: {', '.join(sorted(choices))}")
