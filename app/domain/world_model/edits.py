"""Edits of a world while it runs: what each makes of the world, of its facts, and what takes it back."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, ValidationError

from app.domain.errors import Conflict, Invalid, MactaError, NotFound
from app.domain.world_model.beliefs import (
    CAN,
    IN,
    IN_AREA,
    OBJECT_POSITION,
    OWN_SPOT,
    REACHES,
    VACANT,
    Change,
    Facts,
    occupants,
    place_of,
    revise_beliefs,
    robots_in,
)
from app.domain.world_model.berths import resolve_statements
from app.domain.world_model.initial import initial_facts
from app.domain.world_model.problem import objects_of
from planner import Fact, KnowledgeBase
from robots.data import Checked
from robots.world import Sample, WorldFile

Part = TypeVar("Part")
STRUCTURAL = frozenset({CAN, IN_AREA, OWN_SPOT, REACHES})
"""Predicates of what follows from the world alone."""


class WorldEdit(Checked):
    """One edit."""

    @property
    @abstractmethod
    def touched(self) -> frozenset[str]:
        """The names that no running mission may need."""

    @abstractmethod
    def __str__(self) -> str:
        """What it does, in words that continue "an operator has ..."."""

    @abstractmethod
    def apply(self, world: WorldFile, facts: Facts) -> "Edited":
        """The world after the edit.

        :param facts: believed now.
        :raises MactaError: if it cannot be made.
        """


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
        others = tuple(one for one in world.deliveries if one.name != self.sample.name)
        world = changed(world, deliveries=others)  # one that has arrived is a sample like any other
        _refuse_name_in_use(self.sample.name, world)
        place = _free_place(self.sample, world, facts)
        sample = self.sample.model_copy(update={"at": place})
        lying = [_moved_off(other, place, world, facts) for other in world.samples]
        return Edited(
            changed(world, samples=(*lying, sample)),
            AddSample(sample=sample),
            RemoveSample(name=sample.name),
        )


class RemoveSample(WorldEdit):
    """A sample is taken out of the world, from where it lies or from wherever it was lost."""

    edit: Literal["remove_sample"] = "remove_sample"
    name: str

    @property
    def touched(self) -> frozenset[str]:
        return frozenset({self.name})

    def __str__(self) -> str:
        return f"removed {self.name}"

    def apply(self, world: WorldFile, facts: Facts) -> Edited:
        sample = _known("sample", self.name, {one.name: one for one in world.samples})
        place = place_of(self.name, facts)
        if place in robots_in(facts):
            raise Conflict(f"{place} holds {self.name}; have it put down first", code="sample-held")
        lay = sample if place is None else sample.model_copy(update={"at": place})
        without = changed(
            world,
            samples=tuple(one for one in world.samples if one.name != self.name),
            facts=tuple(fact for fact in world.facts if self.name not in fact.args),
        )
        return Edited(without, self, AddSample(sample=lay))


AnyEdit = Annotated[AddSample | RemoveSample, Field(discriminator="edit")]


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

    Abilities and reach follow the changed world.
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
        fault = error.errors()[0]
        raise Invalid(fault["msg"].removeprefix("Value error, "), code="world-does-not-fit") from error


def _refuse_name_in_use(name: str, world: WorldFile) -> None:
    aisles = [aisle for compartment in world.compartments for aisle in compartment.aisles]
    parts = (
        world.compartments,
        aisles,
        world.obstacles,
        world.locations,
        world.places,
        world.robots,
        world.samples,
        world.deliveries,
    )
    taken = {part.name for group in parts for part in group}
    if name in taken:
        raise Invalid(f"the name {name} is in use in {world.name}", code="name-in-use", thing=name)


def _known(what: str, name: str, choices: Mapping[str, Part]) -> Part:
    if name not in choices:
        raise NotFound(f"unknown {what} {name!r}", code=f"unknown-{what}", choices=tuple(choices), thing=name)
    return choices[name]


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


def _moved_off(sample: Sample, place: str, world: WorldFile, facts: Facts) -> Sample:
    """The sample as a new run begins: where it lay at the start, unless another sample is there now.

    Then it begins where it is believed to lie, or at the first place that no sample starts at.
    """
    if world.initial_places[sample.name] != place:
        return sample
    starts = {*world.initial_places.values(), place}
    choices = [place_of(sample.name, facts), *(one.name for one in world.places if one.capacity)]
    free = [one for one in choices if one in world.location_of and one not in starts]
    return sample.model_copy(update={"at": free[0]}) if free else sample
