"""The world file: its parts checked against each other, and the places that robots know."""

from collections import Counter
from collections.abc import Iterable, Mapping
from functools import cached_property
from itertools import chain, combinations, takewhile
from math import dist
from typing import Any

from pydantic import Field, ValidationError, model_validator
from typing_extensions import Self

from robots.data import Checked
from robots.world.berths import lay_out
from robots.world.parts import (
    NARROWEST_PITCH_M,
    ON_BORDER_M,
    Aisle,
    Compartment,
    Delivery,
    Location,
    Name,
    Obstacle,
    Point,
    RobotSpec,
    Sample,
    Slope,
    Wall,
    WorldFact,
    WorldNumber,
    Zone,
    ZoneRule,
)
from robots.world.peripherals import Peripheral
from robots.world.peripherals import faults_of as peripheral_faults
from robots.world.radio import LinkSpec
from robots.world.slopes import overlapping
from robots.world.walls import WALL_THICKNESS_M, panels_of, solid_pieces

ROBOT_WIDTH_M = 0.44


CLEARANCE = "clearance"
"""What a robot speaks that tells others of the end of its actions, and believes them."""
PERSONS = "persons"
"""What a robot speaks that does what persons ask of it through the service, and answers them."""
BIDS = "bids"
"""What a robot speaks that answers calls for proposals."""
DELEGATION = "delegation"
"""What a robot speaks that puts legs of its script to other robots if it may, and does theirs."""


class WorldFile(Checked):
    """A whole world. Every name is unique in the file; every reference resolves.

    `peer_link`: the radio between two robots; left out, simulated robots do not hear each other.
    """

    name: Name
    title: str = ""
    compartments: tuple[Compartment, ...] = Field(min_length=1)
    walls: tuple[Wall, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    slopes: tuple[Slope, ...] = ()
    peripherals: tuple[Peripheral, ...] = ()
    locations: tuple[Location, ...] = Field(min_length=1)
    robots: tuple[RobotSpec, ...] = Field(min_length=1)
    samples: tuple[Sample, ...] = ()
    deliveries: tuple[Delivery, ...] = ()
    facts: tuple[WorldFact, ...] = ()
    numbers: tuple[WorldNumber, ...] = ()
    link: LinkSpec = LinkSpec()
    peer_link: LinkSpec | None = None

    @model_validator(mode="before")
    @classmethod
    def _read_earlier_areas(cls, data: Any) -> Any:
        """Take the `keep_out` areas of earlier versions, as snapshots and records have them, as zones."""
        areas = data.get("keep_out") if isinstance(data, dict) else None
        if not isinstance(areas, list) or not all(isinstance(area, dict) for area in areas):
            return data
        zones = [{**area, "rule": ZoneRule.KEEP_OUT} for area in areas]
        rest = {name: value for name, value in data.items() if name != "keep_out"}
        return {**rest, "zones": [*rest.get("zones", ()), *zones]}

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy without what this world has worked out of its parts: they may be others there."""
        copied = super().model_copy(update=update, deep=deep)
        for worked_out in vars(copied).keys() - type(self).model_fields.keys():
            del vars(copied)[worked_out]
        return copied

    @cached_property
    def simulated(self) -> tuple[RobotSpec, ...]:
        """The robots that have no software of their own."""
        return tuple(robot for robot in self.robots if not robot.external)

    @cached_property
    def places_by_location(self) -> Mapping[str, tuple[Location, ...]]:
        """Location → its places: its berths if it has room for several samples, else itself."""
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
        return tuple(chain.from_iterable(self.places_by_location.values()))

    @cached_property
    def points(self) -> Mapping[str, Point]:
        """Location or berth → where it is, x and y in metres."""
        return {place.name: place.at for place in (*self.locations, *self.places)}

    @cached_property
    def location_of(self) -> Mapping[str, str]:
        """Place → the location that it is or is a berth of."""
        return {place.name: name for name, row in self.places_by_location.items() for place in row}

    @cached_property
    def kept_out(self) -> Mapping[str, str]:
        """Place in a zone that robots keep out of → the zone."""
        return {
            place.name: zone.name
            for zone in self.zones_of(ZoneRule.KEEP_OUT)
            for place in self.places
            if zone.contains(place.at)
        }

    @cached_property
    def agents(self) -> tuple[RobotSpec | Peripheral, ...]:
        """All that is commanded by scripts: the robots, then the peripherals."""
        return (*self.robots, *self.peripherals)

    @cached_property
    def agents_by_name(self) -> Mapping[str, RobotSpec | Peripheral]:
        return {agent.name: agent for agent in self.agents}

    @cached_property
    def simulated_peripherals(self) -> tuple[Peripheral, ...]:
        """The peripherals that have no software of their own."""
        return tuple(one for one in self.peripherals if not one.external)

    def zones_of(self, rule: ZoneRule) -> tuple[Zone, ...]:
        """The zones with this rule."""
        return tuple(zone for zone in self.zones if zone.rule is rule)

    @cached_property
    def initial_places(self) -> Mapping[str, str]:
        """Sample → the place where it lies at the start; at a location with berths, the first free one.

        :raises ValueError: if more samples start at a location than it has room for.
        """
        places = {sample.name: sample.at for sample in self.samples}
        taken = set(places.values())
        free = {
            name: iter([p.name for p in row if p.name not in taken])
            for name, row in self.places_by_location.items()
        }
        for sample, at in places.items():
            if at not in self.location_of:
                places[sample] = next(free[at], at)
        for name, count in Counter(self.location_of.get(at, at) for at in places.values()).items():
            room = sum(place.capacity for place in self.places_by_location[name])
            if count > room:
                raise ValueError(f"{name} has room for {room} samples, but {count} start there")
        for place, count in Counter(places.values()).items():
            if count > 1:
                raise ValueError(f"{place} has room for 1 sample, but {count} start there")
        return places

    @cached_property
    def robots_by_name(self) -> Mapping[str, RobotSpec]:
        return {robot.name: robot for robot in self.robots}

    @cached_property
    def links(self) -> Mapping[str, LinkSpec]:
        """Robot or peripheral → its radio."""
        robots = {robot.name: self.link_of(robot) for robot in self.robots}
        return robots | dict.fromkeys((one.name for one in self.peripherals), self.link)

    @cached_property
    def lengths_m(self) -> Mapping[str, float]:
        """Long sample → its length, metres."""
        return {sample.name: sample.length_m for sample in self.samples if sample.length_m}

    @cached_property
    def reached_by(self) -> Mapping[str, tuple[str, ...]]:
        """Robot → the places that it reaches."""
        return {robot.name: tuple(place.name for place in self.reach_of(robot)) for robot in self.robots}

    def location(self, name: str) -> Location:
        """The location or berth of that name."""
        return next(place for place in (*self.locations, *self.places) if place.name == name)

    def robot(self, name: str) -> RobotSpec:
        return self.robots_by_name[name]

    def link_of(self, robot: RobotSpec) -> LinkSpec:
        """The robot's radio: its own values, with the world's as defaults."""
        return self.link if robot.link is None else robot.link.over(self.link)

    def speaks(self, robot: RobotSpec, what: str) -> bool:
        """True if the robot says this and takes it; what robots say to each other needs the radio between them."""
        if what in (CLEARANCE, DELEGATION) and self.peer_link is None and not robot.external:
            return False
        return not robot.external if robot.speaks is None else what in robot.speaks

    def has_social_level(self, robot: RobotSpec) -> bool:
        """True if the software of a simulated robot speaks at all."""
        return robot.speaks is None or bool(robot.speaks)

    @cached_property
    def clearing(self) -> frozenset[str]:
        """The robots that clear each other."""
        return frozenset(robot.name for robot in self.robots if self.speaks(robot, CLEARANCE))

    @cached_property
    def delegating(self) -> frozenset[str]:
        """The robots that do each other's legs if they may: each can make way for the other.

        It has a home, and that lies in no zone for one robot at a time.
        """
        places = {place.name: place.at for place in self.places}
        alone = [zone for zone in self.zones if zone.rule is ZoneRule.ONE_ROBOT]
        return frozenset(
            robot.name
            for robot in self.robots
            if self.speaks(robot, DELEGATION)
            and robot.home in places
            and not any(zone.contains(places[robot.home]) for zone in alone)
        )

    @property
    def answer_s(self) -> float:
        """`LinkSpec.answer_s` of the robot with the poorest radio."""
        return max(link.answer_s for link in self.links.values())

    def area_of(self, robot: RobotSpec) -> Aisle:
        """The robot's allocated area: its aisle if it has one, else its whole compartment."""
        compartment = next(c for c in self.compartments if c.name == robot.compartment)
        return next((a for a in compartment.aisles if a.name == robot.aisle), compartment)

    def reach_of(self, robot: RobotSpec) -> tuple[Location, ...]:
        """The places inside or on the border of the robot's area, without the homes of other robots."""
        area = self.area_of(robot)
        return tuple(
            place
            for place in self.places
            if area.contains(place.at) and (place.kind != "home" or place.name == robot.home)
        )

    @cached_property
    def chargers(self) -> tuple[Location, ...]:
        """The places where any robot that reaches them is charged."""
        return tuple(place for place in self.locations if place.kind == "charger")

    def chargers_of(self, robot: RobotSpec) -> tuple[Location, ...]:
        """Where the robot is charged, one robot at a time: its home, and the chargers that it reaches."""
        area = self.area_of(robot)
        shared = (place for place in self.chargers if area.contains(place.at) and place.name != robot.home)
        return (*(() if robot.home is None else (self.location(robot.home),)), *shared)

    @model_validator(mode="after")
    def _check(self) -> Self:
        aisles = [aisle for compartment in self.compartments for aisle in compartment.aisles]
        parts = (
            self.compartments,
            aisles,
            self.obstacles,
            self.zones,
            self.slopes,
            self.peripherals,
            self.locations,
            self.robots,
            self.samples,
            self.deliveries,
        )
        names = [part.name for group in parts for part in group]
        names += dict.fromkeys(level for one in self.peripherals for level in one.levels)
        names += (one.passage for one in self.peripherals if one.passage)
        _unique(names)
        self._check_building()
        self._check_obstacles()
        if (pair := overlapping(self.slopes)) is not None:
            first, second = (slope.name for slope in pair)
            raise ValueError(f"slopes.{second} overlaps slopes.{first}; a point is on one slope at most")
        locations = {location.name: location for location in self.locations}
        for robot in self.robots:
            self._check_robot(robot, locations)
        self._check_walls()
        self._check_distances()
        if fault := next(peripheral_faults(self.peripherals, self.walls, self.places), None):
            raise ValueError(fault)
        for one, other in combinations(self.robots, 2):
            if dist(one.start[:2], other.start[:2]) < ROBOT_WIDTH_M:
                raise ValueError(
                    f"robots.{one.name} and robots.{other.name} start nearer than {ROBOT_WIDTH_M} m to each other"
                )
        _unique(
            [
                *names,
                *(place.name for row in self.places_by_location.values() if len(row) > 1 for place in row),
            ]
        )
        for sample in self.samples:
            _known(
                "location",
                sample.at,
                {**self.places_by_location, **self.location_of},
                f"samples.{sample.name}.at",
            )
        for delivery in self.deliveries:
            _known("place", delivery.at, self.location_of, f"deliveries.{delivery.name}.at")
            if self.location(delivery.at).capacity == 0:
                raise ValueError(f"deliveries.{delivery.name}.at: {delivery.at} holds no samples")
        for name, place in self.initial_places.items():
            self._check_sample_place(name, place)
        return self

    def _check_building(self) -> None:
        for location in self.locations:
            if not any(compartment.contains(location.at) for compartment in self.compartments):
                raise ValueError(f"locations.{location.name} at {location.at} lies in no compartment")
            if location.kind == "home" and location.capacity > 1:
                raise ValueError(f"locations.{location.name}: a home has no berths, capacity must be 0 or 1")
            if location.kind == "charger" and location.capacity > 0:
                raise ValueError(f"locations.{location.name}: a charger holds no samples, capacity must be 0")
        for wall in self.walls:
            for opening in wall.openings:
                if opening.at_m + opening.width_m / 2 > wall.length_m:
                    raise ValueError(
                        f"{opening.kind} at {opening.at_m} m ends beyond its wall, which is {wall.length_m:.2f} m long"
                    )

    def _check_walls(self) -> None:
        """No robot starts in a wall, and no location lies in one but at a hatch or gap."""
        for index, wall in enumerate(self.walls):
            for panel in solid_pieces(wall):
                stands = f"walls.{index} from {_point(panel.start)} to {_point(panel.end)}"
                for robot in self.robots:
                    if panel.distance_m(robot.start[:2]) < ROBOT_WIDTH_M / 2:
                        raise ValueError(
                            f"robots.{robot.name} starts at {_point(robot.start[:2])}, in {stands}; "
                            f"its middle must be {ROBOT_WIDTH_M / 2:.2f} m from it"
                        )
                for location in self.locations:
                    if not panel.door and panel.distance_m(location.at) < WALL_THICKNESS_M / 2:
                        raise ValueError(
                            f"locations.{location.name} lies at {_point(location.at)}, in {stands}; "
                            "move it, or give the wall a hatch or gap there"
                        )

    def _check_distances(self) -> None:
        """No two locations coincide; those that hold samples are so far apart that a robot can distinguish them."""
        by_x = sorted(self.locations, key=lambda location: location.at)
        for index, one in enumerate(by_x):
            near = takewhile(lambda o: o.at[0] - one.at[0] < NARROWEST_PITCH_M, by_x[index + 1 :])  # noqa: B023
            for other in near:
                least_m = NARROWEST_PITCH_M if one.capacity and other.capacity else ON_BORDER_M
                if dist(one.at, other.at) < least_m - 1e-6:
                    raise ValueError(
                        f"locations.{other.name} at {_point(other.at)} is {dist(one.at, other.at):.2f} m from "
                        f"locations.{one.name} at {_point(one.at)}, at least {least_m} m is needed"
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

    def _check_sample_place(self, sample: str, place: str) -> None:
        """Check that no fact of the file contradicts the sample's place."""
        here = {place, self.location_of[place]}
        elsewhere = {
            (sample, name) for name in (*self.places_by_location, *self.location_of) if name not in here
        }
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


def _point(point: Point) -> str:
    return f"({point[0]:g}, {point[1]:g})"


def _unique(names: list[str]) -> None:
    doubles = sorted(name for name, count in Counter(names).items() if count > 1)
    if doubles:
        raise ValueError(
            f"names must be unique in a world, names of berths included; used more than once: {', '.join(doubles)}"
        )


def _known(what: str, name: str, choices: Iterable[str], where: str) -> None:
    if name not in choices:
        raise ValueError(f"{where}: unknown {what} {name!r}; choices: {', '.join(sorted(choices))}")
