"""Edits of a world while it runs: what each makes of the world, of its facts, and what takes it back."""

from abc import abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import Field, SerializerFunctionWrapHandler, ValidationError, model_serializer, model_validator

from app.domain.errors import Conflict, Invalid, MactaError, NotFound
from app.domain.world_model.beliefs import (
    IN,
    NEAR,
    OBJECT_POSITION,
    REACHES,
    ROBOT_POSITION,
    STRUCTURAL,
    VACANT,
    Change,
    Facts,
    occupants,
    place_of,
    revise_beliefs,
    robots_in,
    spot_of,
)
from app.domain.world_model.berths import resolve_statements
from app.domain.world_model.initial import initial_facts
from app.domain.world_model.problem import objects_of
from planner import Fact, KnowledgeBase
from robots.data import Checked
from robots.world import (
    Delivery,
    LinkSpec,
    Location,
    Peripheral,
    RobotSpec,
    Sample,
    WorldFile,
    Zone,
    ZoneRule,
)
from robots.world.bodies import BodySpec
from robots.world.parts import Architecture, Name, Sonar, SonarPart, Speed, Start, Tag, Tuning, TurnRate
from robots.world.sensors import SensorSpec

Part = TypeVar("Part", Sample, RobotSpec, Peripheral, Location, Zone, Delivery)


class WorldEdit(Checked):
    """One edit."""

    @property
    def touched(self) -> frozenset[str]:
        """The names that no running mission may need."""
        return frozenset()

    @abstractmethod
    def __str__(self) -> str:
        """What it does, in words that continue "an operator has ..."."""

    @abstractmethod
    def apply(self, world: WorldFile, facts: Facts) -> "Edited":
        """The world after the edit.

        :param facts: believed now.
        :raises MactaError: if it cannot be made.
        """


class EditOfOne(WorldEdit):
    """An edit of one part that the world has."""

    name: str

    @property
    def touched(self) -> frozenset[str]:
        return frozenset({self.name})


@dataclass(frozen=True, slots=True)
class Edited:
    """A world after an edit, the edit as it was made, and the one that takes it back."""

    world: WorldFile
    made: "AnyEdit"
    undo: "AnyEdit"


class AddSample(WorldEdit):
    """A sample that lies somewhere now. At a location with several berths it lies in the first free one."""

    edit: Literal["add_sample"] = "add_sample"
    sample: Sample

    @property
    def touched(self) -> frozenset[str]:
        return frozenset({self.sample.at})

    def __str__(self) -> str:
        return f"added {self.sample.name} at {self.sample.at}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        others = _without(self.sample.name, world.deliveries)
        world = changed(world, deliveries=others)  # one that has arrived is a sample like any other
        _refuse_name_in_use(self.sample.name, world)
        place = _free_place(self.sample, world, facts)
        sample = self.sample.model_copy(update={"at": place})
        return Edited(
            changed(world, samples=(*_starting_off({place}, world, facts), sample)),
            AddSample(sample=sample),
            RemoveSample(name=sample.name),
        )


class RemoveSample(EditOfOne):
    """A sample is taken out of the world, from where it lies or from wherever it was lost."""

    edit: Literal["remove_sample"] = "remove_sample"

    def __str__(self) -> str:
        return f"removed {self.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        sample = _known("sample", self.name, world.samples)
        place = place_of(self.name, facts)
        if place in robots_in(facts):
            raise Conflict(f"{place} holds {self.name}; have it put down first", code="sample-held")
        lay = sample if place is None else sample.model_copy(update={"at": place})
        without = changed(
            world,
            samples=_without(self.name, world.samples),
            facts=tuple(fact for fact in world.facts if self.name not in fact.args),
            numbers=tuple(one for one in world.numbers if self.name not in one.args),
        )
        return Edited(without, self, AddSample(sample=lay))


class AddRobot(WorldEdit):
    """A robot that stands at its start now, as a world file describes one."""

    edit: Literal["add_robot"] = "add_robot"
    robot: RobotSpec

    def __str__(self) -> str:
        return f"added {self.robot.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        _refuse_name_in_use(self.robot.name, world)
        robots = (*world.robots, self.robot)
        return Edited(changed(world, robots=robots), self, RemoveRobot(name=self.robot.name))


class RemoveRobot(EditOfOne):
    """A robot is taken out of the world for good."""

    edit: Literal["remove_robot"] = "remove_robot"

    def __str__(self) -> str:
        return f"removed {self.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        robot = _known("robot", self.name, world.robots)
        if held := occupants(self.name, facts):
            raise Conflict(
                f"{self.name} holds {', '.join(held)}; have it put down first", code="robot-holds-sample"
            )
        if len(world.robots) == 1:
            raise Conflict(f"{self.name} is the only robot of {world.name}", code="last-robot")
        without = changed(
            world,
            robots=_without(self.name, world.robots),
            facts=tuple(fact for fact in world.facts if self.name not in fact.args),
            numbers=tuple(one for one in world.numbers if self.name not in one.args),
        )
        return Edited(without, self, AddRobot(robot=robot))


RINGS: frozenset[SonarPart] = frozenset(("real", "map"))
"""The sources of a ring of ranges."""


class ChangeRobot(EditOfOne):
    """A robot is otherwise from now on, where it stands; what is left out stays as it is."""

    edit: Literal["change_robot"] = "change_robot"
    compartment: Name | None = None
    aisle: Name | None = Field(default=None, description="null: the whole compartment")
    start: Start | None = Field(default=None, description="where it stands when a new run begins")
    home: Name | None = Field(default=None, description="null: it has none")
    architecture: Architecture | None = None
    repertoire: tuple[Tag, ...] | None = None
    speed_m_s: Speed | None = None
    turn_rad_s: TurnRate | None = None
    body: BodySpec | None = None
    sonar: Sonar | None = None
    sensors: tuple[SensorSpec, ...] | None = None
    senses: tuple[Name, ...] | None = Field(
        default=None, max_length=64, description="null: what its sensors perceive"
    )
    speaks: tuple[Name, ...] | None = Field(
        default=None, max_length=16, description="null: what its software can, if the world has a peer_link"
    )
    tuning: Tuning | None = None
    link: LinkSpec | None = Field(default=None, description="null: the world's")
    external: bool | None = Field(
        default=None,
        description="true: software of its own speaks for it; false: its twin is simulated instead",
    )

    def swaps_ring(self, robot: RobotSpec) -> bool:
        """True if only the source of the robot's ring of ranges changes: a mission may need the robot meanwhile."""
        if self.values.keys() != {"sonar"}:
            return False
        before = set(robot.sonar)
        after = set(self.sonar or ())
        return len(before & RINGS) == len(after & RINGS) == 1 and before - RINGS == after - RINGS

    @property
    def replaces(self) -> bool:
        """True if a simulated twin takes the robot's place, or the other way round."""
        return self.external is not None

    @property
    def values(self) -> dict[str, Any]:
        """What is given, by the field of a `RobotSpec`."""
        return {name: getattr(self, name) for name in sorted(self.model_fields_set - {"edit", "name"})}

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if not self.values:
            choices = ", ".join(name for name in type(self).model_fields if name not in ("edit", "name"))
            raise ValueError(f"nothing of {self.name} is changed; state one of {choices}")
        return self

    @model_serializer(mode="wrap")
    def _without_what_stays(self, serialize: SerializerFunctionWrapHandler):  # type: ignore[no-untyped-def]
        # NOTE: with a return type, the JSON schema would be that type's instead of the model's.
        return {
            name: value
            for name, value in serialize(self).items()
            if name in self.model_fields_set or name == "edit"
        }

    def __str__(self) -> str:
        return f"changed {self.name}: {', '.join(self.values)}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        robot = _known("robot", self.name, world.robots)
        if self.replaces and (held := occupants(self.name, facts)):
            raise Conflict(
                f"{self.name} holds {', '.join(held)}, which its twin would not; have it put down first",
                code="robot-holds-sample",
                thing=self.name,
            )
        try:
            other = RobotSpec.model_validate(dict(robot) | self.values)
        except ValidationError as error:
            raise _unfit(error) from error
        robots = tuple(other if one.name == self.name else one for one in world.robots)
        after = changed(world, robots=robots)
        _refuse_left_outside(other, after, facts)
        back = {name: getattr(robot, name) for name in self.values}
        return Edited(after, self, ChangeRobot(name=self.name, **back))


class AddPeripheral(WorldEdit):
    """A door, hatch or lift with software of its own, as a world file describes one, in its state at the start."""

    edit: Literal["add_peripheral"] = "add_peripheral"
    peripheral: Peripheral

    def __str__(self) -> str:
        return f"added {self.peripheral.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        name = self.peripheral.name
        _refuse_name_in_use(name, world)
        _refuse_simulated(self.peripheral)
        peripherals = (*world.peripherals, self.peripheral)
        return Edited(changed(world, peripherals=peripherals), self, RemovePeripheral(name=name))


class RemovePeripheral(EditOfOne):
    """A door, hatch or lift with software of its own is taken away; what it closed is open."""

    edit: Literal["remove_peripheral"] = "remove_peripheral"

    def __str__(self) -> str:
        return f"removed {self.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        peripheral = _known("peripheral", self.name, world.peripherals)
        _refuse_simulated(peripheral)
        peripherals = _without(self.name, world.peripherals)
        return Edited(changed(world, peripherals=peripherals), self, AddPeripheral(peripheral=peripheral))


class ChangePeripheral(WorldEdit):
    """A door, hatch or lift with software of its own is otherwise from now on; it stands as it is believed to."""

    edit: Literal["change_peripheral"] = "change_peripheral"
    peripheral: Peripheral

    @property
    def touched(self) -> frozenset[str]:
        return frozenset({self.peripheral.name})

    def __str__(self) -> str:
        return f"changed {self.peripheral.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        name = self.peripheral.name
        before = _known("peripheral", name, world.peripherals)
        _refuse_simulated(before)
        _refuse_simulated(self.peripheral)
        if (before.kind, before.levels) != (self.peripheral.kind, self.peripheral.levels):
            raise Invalid(
                f"{name} is a {before.kind}, with other levels or none; remove it and add it again",
                code="peripheral-is-another",
                thing=name,
            )
        peripherals = tuple(self.peripheral if one.name == name else one for one in world.peripherals)
        return Edited(changed(world, peripherals=peripherals), self, ChangePeripheral(peripheral=before))


class AddPlace(WorldEdit):
    """A place with its beacon; robots whose area it lies in reach it."""

    edit: Literal["add_place"] = "add_place"
    place: Location

    def __str__(self) -> str:
        return f"added {self.place.name} at {point_words(self.place.at)}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        _refuse_name_in_use(self.place.name, world)
        locations = (*world.locations, self.place)
        return Edited(changed(world, locations=locations), self, RemovePlace(name=self.place.name))


class MovePlace(EditOfOne):
    """A place is elsewhere from now on; `approach_deg` stays unless it is given. A robot near it stays where it is."""

    edit: Literal["move_place"] = "move_place"
    at: tuple[float, float]
    approach_deg: tuple[float, ...] | None = Field(default=None, min_length=1)

    def __str__(self) -> str:
        return f"moved {self.name} to {point_words(self.at)}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        place = _empty_place(self.name, world, facts)
        moved = place.model_copy(
            update={"at": self.at, "approach_deg": self.approach_deg or place.approach_deg}
        )
        locations = tuple(moved if one.name == self.name else one for one in world.locations)
        back = MovePlace(name=self.name, at=place.at, approach_deg=place.approach_deg)
        return Edited(changed(world, locations=locations), self, back)


class RemovePlace(EditOfOne):
    """A place is taken away with its beacon."""

    edit: Literal["remove_place"] = "remove_place"

    def __str__(self) -> str:
        return f"removed {self.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        place = _empty_place(self.name, world, facts)
        if (robot := next((one.name for one in world.robots if one.home == self.name), None)) is not None:
            raise Conflict(f"{self.name} is the home of {robot}", code="place-is-home", thing=robot)
        gone = {self.name, *(berth.name for berth in world.places_by_location[self.name])}
        without = changed(
            world,
            samples=_starting_off(gone, world, facts),
            locations=_without(self.name, world.locations),
            deliveries=tuple(one for one in world.deliveries if one.at not in gone),
            facts=tuple(fact for fact in world.facts if not gone.intersection(fact.args)),
            numbers=tuple(one for one in world.numbers if not gone.intersection(one.args)),
        )
        return Edited(without, self, AddPlace(place=place))


class AddZone(WorldEdit):
    """An area that goals can name, and whose rule holds from now on. A robot that is inside may leave."""

    edit: Literal["add_zone"] = "add_zone"
    zone: Zone

    def __str__(self) -> str:
        name = self.zone.name
        match self.zone.rule:
            case ZoneRule.NAMED:
                return f"named {name}"
            case ZoneRule.KEEP_OUT:
                return f"closed {name}"
            case ZoneRule.ONE_ROBOT:
                return f"limited {name} to one robot"
            case ZoneRule.SLOW:
                return f"limited {name} to {self.zone.max_speed_m_s:g} m/s"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        _refuse_name_in_use(self.zone.name, world)
        if why := self.zone.misplaced(world.compartments):
            raise Invalid(why, code="world-does-not-fit", thing=self.zone.name)
        zones = (*world.zones, self.zone)
        return Edited(changed(world, zones=zones), self, RemoveZone(name=self.zone.name))


class RemoveZone(EditOfOne):
    """An area loses its name, and its rule no longer holds."""

    edit: Literal["remove_zone"] = "remove_zone"

    def __str__(self) -> str:
        return f"removed {self.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        zone = _known("zone", self.name, world.zones)
        zones = _without(self.name, world.zones)
        return Edited(changed(world, zones=zones), self, AddZone(zone=zone))


AnyEdit = Annotated[
    AddSample
    | RemoveSample
    | AddRobot
    | RemoveRobot
    | ChangeRobot
    | AddPeripheral
    | RemovePeripheral
    | ChangePeripheral
    | AddPlace
    | MovePlace
    | RemovePlace
    | AddZone
    | RemoveZone,
    Field(discriminator="edit"),
]


def apply_edits(
    world: WorldFile, edits: Sequence[WorldEdit], facts: Facts, knowledge_base: KnowledgeBase
) -> "EditedWorld":
    """The world and its facts after all edits, in order.

    :raises MactaError: if one cannot be made; the message begins with its place, "edits.0".
    """
    made: list[AnyEdit] = []
    undo: list[AnyEdit] = []
    for index, edit in enumerate(edits):
        try:
            edited = edit.apply(world, facts)
        except MactaError as error:
            raise type(error)(
                f"edits.{index}: {error.detail}", code=error.code, choices=error.choices, thing=error.thing
            ) from error
        facts = fact_change(facts, world, edited.world, knowledge_base)
        world = edited.world
        made.append(edited.made)
        undo.insert(0, edited.undo)
    return EditedWorld(world=world, facts=facts, made=tuple(made), undo=tuple(undo))


@dataclass(frozen=True, slots=True, kw_only=True)
class EditedWorld:
    """A world and its facts after edits, the edits as they were made, and those that take them back."""

    world: WorldFile
    facts: Facts
    made: tuple[AnyEdit, ...]
    undo: tuple[AnyEdit, ...]

    def change(self, before: Facts) -> Change:
        """What has changed of the facts."""
        return Change(add=self.facts - before, remove=before - self.facts)


def fact_change(facts: Facts, before: WorldFile, after: WorldFile, knowledge_base: KnowledgeBase) -> Facts:
    """The facts once a world has changed: none of what is gone, the initial ones of what is new, others as believed.

    What a robot is, can and reaches follows the changed world. A robot near a place that is now elsewhere, or that it
    no longer reaches, stands at its own spot.
    """
    old = objects_of(before).keys()
    new = objects_of(after).keys()
    gone = old - new
    at_start = initial_facts(before, knowledge_base)
    at_new_start = initial_facts(after, knowledge_base)
    news = {
        fact
        for fact in at_new_start - at_start
        if fact.predicate in STRUCTURAL or set(fact.args) & (new - old)
    }
    ended = {fact for fact in at_start - at_new_start if fact.predicate in STRUCTURAL}
    left = {fact for fact in facts if not gone.intersection(fact.args)} - ended
    moved = {name for name, point in after.points.items() if before.points.get(name, point) != point} | gone
    news |= {
        Fact(ROBOT_POSITION, (fact.args[0], NEAR, spot_of(fact.args[0])))
        for fact in facts
        if fact.predicate == ROBOT_POSITION
        and fact.args[0] not in gone
        and (fact.args[2] in moved or Fact(REACHES, (fact.args[0], fact.args[2])) in ended)
    }
    emptied = {
        fact.args[2]
        for fact in facts
        if fact.predicate == OBJECT_POSITION and fact.args[0] in gone and fact.args[2] not in gone
    }
    places = {place.name for place in after.places if place.capacity}
    left |= {Fact(VACANT, (place,)) for place in emptied & places}
    return revise_beliefs(frozenset(left), sorted(news))


def changed(world: WorldFile, **parts: Any) -> WorldFile:
    """The world with other parts, checked as a world file is.

    :raises Invalid: if they do not fit; the message is the world file's.
    """
    try:
        return WorldFile(**{name: parts.get(name, getattr(world, name)) for name in WorldFile.model_fields})
    except ValidationError as error:
        raise _unfit(error) from error


def _unfit(error: ValidationError) -> Invalid:
    fault = error.errors()[0]
    where = ".".join(map(str, fault["loc"]))
    words = fault["msg"].removeprefix("Value error, ")
    return Invalid(f"{where}: {words}" if where else words, code="world-does-not-fit")


def _refuse_left_outside(robot: RobotSpec, world: WorldFile, facts: Facts) -> None:
    """Refuse that a robot gets another area than the one that it is believed to stand in."""
    area = world.area_of(robot)
    for fact in facts:
        if fact.predicate == ROBOT_POSITION and fact.args[0] == robot.name:
            point = world.points.get(fact.args[2])
            if point is not None and not area.contains(point):
                raise Conflict(
                    f"{robot.name} is at {fact.args[2]}, outside {area.name}; have it go elsewhere first",
                    code="robot-outside-area",
                    thing=robot.name,
                )


def _refuse_name_in_use(name: str, world: WorldFile) -> None:
    aisles = [aisle for compartment in world.compartments for aisle in compartment.aisles]
    parts = (
        world.compartments,
        aisles,
        world.obstacles,
        world.zones,
        world.slopes,
        world.locations,
        world.places,
        world.agents,
        world.samples,
        world.deliveries,
    )
    taken = {part.name for group in parts for part in group}
    if name in taken:
        raise Invalid(f"the name {name} is in use in {world.name}", code="name-in-use", thing=name)


def _refuse_simulated(peripheral: Peripheral) -> None:
    if not peripheral.external:
        raise Invalid(
            f"{peripheral.name} is simulated, or to be; change the world's file, or make it external there",
            code="peripheral-is-simulated",
            thing=peripheral.name,
        )


def _known(what: str, name: str, parts: Sequence[Part]) -> Part:
    """The part of that name."""
    choices = {part.name: part for part in parts}
    if name not in choices:
        code = f"unknown-{what.replace(' ', '-')}"
        raise NotFound(f"unknown {what} {name!r}", code=code, choices=tuple(choices), thing=name)
    return choices[name]


def _without(name: str, parts: Sequence[Part]) -> tuple[Part, ...]:
    """All parts but the one of that name."""
    return tuple(part for part in parts if part.name != name)


def _empty_place(name: str, world: WorldFile, facts: Facts) -> Location:
    """The location of that name, if nothing lies there."""
    place = _known("place", name, world.locations)
    berths = [berth.name for berth in world.places_by_location[name]]
    if lying := [sample for berth in berths for sample in occupants(berth, facts)]:
        raise Conflict(
            f"{', '.join(lying)} lies in {name}; have it taken elsewhere first",
            code="place-holds-sample",
            thing=lying[0],
        )
    return place


def point_words(point: tuple[float, float]) -> str:
    """A point in metres, as messages write it."""
    return f"({point[0]:g}, {point[1]:g})"


def _free_place(sample: Sample, world: WorldFile, facts: Facts) -> str:
    """The place that a new sample lies in.

    :raises NotFound: if there is none of that name. :raises Conflict: if it is not vacant.
    """
    vacant = [place.name for place in world.places if Fact(VACANT, (place.name,)) in facts]
    if sample.at not in {**world.places_by_location, **world.location_of}:
        raise NotFound(f"unknown place {sample.at!r}", code="unknown-place", choices=vacant, thing=sample.at)
    ((_, (_, place), _),) = resolve_statements([(IN, (sample.name, sample.at), True)], world, facts)
    if place not in vacant:
        lying = occupants(place, facts)
        why = (
            f"{', '.join(lying)} lies there"
            if lying
            else f"it is a {world.location(place).kind}, which holds none"
        )
        raise Conflict(
            f"{place} has no room for {sample.name}: {why}",
            code="place-occupied",
            choices=vacant,
            thing=place,
        )
    return place


def _starting_off(taken: Collection[str], world: WorldFile, facts: Facts) -> tuple[Sample, ...]:
    """The samples as a new run begins, none of them in the places that are taken.

    Each lies where it lay at the start; one whose place is taken, where it is believed to lie, or in the first place
    that no sample starts in.
    """
    starts = {*world.initial_places.values(), *taken}
    samples = []
    for sample in world.samples:
        if world.initial_places[sample.name] in taken:
            choices = [
                place_of(sample.name, facts) or "",
                *(one.name for one in world.places if one.capacity),
            ]
            free = [one for one in choices if one in world.location_of and one not in starts]
            if not free:
                raise Conflict(f"no place is left for {sample.name} to start in", code="no-room")
            starts.add(free[0])
            samples.append(sample.model_copy(update={"at": free[0]}))
        else:
            samples.append(sample)
    return tuple(samples)
