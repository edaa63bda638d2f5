"""The verbs of goals as data: words, slots, and the facts that a command stands for (a domain pack's `verbs.yaml`)."""

import itertools
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Self

import yaml
from pydantic import Field, ValidationError, field_validator, model_validator

from app.domain.errors import MactaError
from robots.data import Checked, faults_in, read_yaml

SHIPPED = "verbs.yaml"
"""The file beside this module, with the verbs of the sample store."""
_CALL = re.compile(r"^\s*([a-z][a-z0-9_]*)\s*\(([^()]*)\)\s*$")
_TERM = re.compile(r"^\??[a-z][a-z0-9_]*$")
Identifier = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=64)]
Word = Annotated[str, Field(pattern=r"^[a-z]+$", max_length=32)]


class VerbsError(MactaError):
    """Raised when verbs are not valid, or two files state the same word; names the files, the verb and the slot."""

    code = "verbs"


class Kind(StrEnum):
    """The kind of thing that fills a slot."""

    SAMPLE = "sample"
    """A sample of the world."""
    ROBOT = "robot"
    """A robot of the world."""
    PLACE = "place"
    """A location of the world, or one of its berths."""


class Role(StrEnum):
    """The part of a command that fills a slot."""

    OBJECT = "object"
    """What follows the verb."""
    TARGET = "target"
    """What follows "to", "in", "at" or "on"."""
    PARTNER = "partner"
    """What follows "and" or "with": "swap sample_1 with sample_2"."""


class Function(StrEnum):
    """How a value is derived from another slot's."""

    PLACE_OF = "place_of"
    """Where a sample lies."""
    PARKING_OF = "parking_of"
    """A robot's home; without one, a free parking place that it reaches."""
    CHARGER_OF = "charger_of"
    """Where a robot is charged: its home; without one, a charger that it reaches, a free one if there is."""
    KNOWN = "known"
    """The last argument of a known fact: `known(kept_in, ?tool)` is where the tool is kept."""


ARGUMENT = {
    Function.PLACE_OF: Kind.SAMPLE,
    Function.PARKING_OF: Kind.ROBOT,
    Function.CHARGER_OF: Kind.ROBOT,
}
"""The kind of slot that each function takes."""


@dataclass(frozen=True, slots=True)
class Call:
    """A predicate or function with its terms; a term that begins with `?` is a slot or a given value."""

    name: str
    terms: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.name}({', '.join(self.terms)})"

    @property
    def variables(self) -> tuple[str, ...]:
        return tuple(term[1:] for term in self.terms if term.startswith("?"))

    @classmethod
    def parse(cls, text: str) -> Self:
        """:raises ValueError: if the text is not `name(term, …)` with names and ?variables."""
        match = _CALL.match(text)
        if match is None:
            raise ValueError(f"{text!r} is not of the form name(term, …)")
        terms = tuple(term.strip() for term in match[2].split(","))
        if bad := [term for term in terms if not _TERM.match(term)]:
            raise ValueError(f"{text!r}: {bad[0]!r} is neither a name nor a ?variable")
        return cls(match[1], terms)

    def filled(self, values: Mapping[str, str]) -> tuple[str, ...]:
        """The terms with values instead of variables."""
        return tuple(values[term[1:]] if term.startswith("?") else term for term in self.terms)


class Slot(Checked):
    """An argument of a verb."""

    kind: Kind
    role: Role
    likely: tuple[str, ...] = ()
    default: str | None = None


class Verb(Checked):
    """A verb as its file states it."""

    name: Identifier
    words: tuple[Word, ...] = Field(min_length=1)
    slots: dict[Identifier, Slot] = Field(min_length=1)
    given: dict[Identifier, str] = Field(default_factory=dict)
    goals: tuple[str, ...] = Field(min_length=1)

    @field_validator("goals")
    @classmethod
    def _are_facts(cls, goals: tuple[str, ...]) -> tuple[str, ...]:
        for goal in goals:
            Call.parse(goal)
        return goals

    @model_validator(mode="after")
    def _variables_are_slots(self) -> Self:
        roles = [slot.role for slot in self.slots.values()]
        if Role.OBJECT not in roles or len(roles) != len(set(roles)):
            raise ValueError(
                f"slots: one slot must be the object, and no two the same part: {', '.join(roles)}"
            )
        if both := sorted(set(self.slots) & set(self.given)):
            raise ValueError(f"given.{both[0]}: there is a slot of this name")
        for where, text in self._derivations():
            self._check_derivation(where, Call.parse(text))
        for index, goal in enumerate(self.templates):
            known = {*self.slots, *self.given}
            if unknown := [name for name in goal.variables if name not in known]:
                raise ValueError(
                    f"goals.{index}: no slot {unknown[0]!r} for {goal}; choices: {', '.join(sorted(known))}"
                )
        return self

    def _derivations(self) -> Iterable[tuple[str, str]]:
        yield from ((f"given.{name}", text) for name, text in self.given.items())
        for name, slot in self.slots.items():
            if slot.default is not None:
                yield f"slots.{name}.default", slot.default

    def _check_derivation(self, where: str, call: Call) -> None:
        if call.name not in list(Function):
            raise ValueError(f"{where}: unknown function {call.name!r}; choices: {', '.join(Function)}")
        if call.name == Function.KNOWN:
            self._check_known(where, call)
            return
        kind = ARGUMENT[Function(call.name)]
        fitting = sorted(name for name, slot in self.slots.items() if slot.kind is kind)
        if len(call.terms) != 1 or call.variables[:1] not in [(name,) for name in fitting]:
            choices = ", ".join(f"?{name}" for name in fitting) or "none"
            raise ValueError(f"{where}: {call.name} takes a slot of kind {kind}; choices: {choices}")

    def _check_known(self, where: str, call: Call) -> None:
        predicate, *terms = call.terms
        if predicate.startswith("?"):
            raise ValueError(f"{where}: {call.name} takes a predicate first, not {predicate}")
        earlier = [*self.slots, *itertools.takewhile(lambda name: where != f"given.{name}", self.given)]
        if unknown := [term for term in terms if term.startswith("?") and term[1:] not in earlier]:
            choices = ", ".join(f"?{name}" for name in earlier)
            raise ValueError(f"{where}: no slot {unknown[0]!r} for {call}; choices: {choices}")

    @cached_property
    def templates(self) -> tuple[Call, ...]:
        """The goal facts with variables."""
        return tuple(map(Call.parse, self.goals))

    @cached_property
    def derived(self) -> Mapping[str, Call]:
        """Given value → how it is derived."""
        return {name: Call.parse(text) for name, text in self.given.items()}

    def slot(self, role: Role) -> str | None:
        """The name of the slot that this part of a command fills."""
        return next((name for name, slot in self.slots.items() if slot.role is role), None)

    @property
    def object_kind(self) -> Kind:
        return next(slot.kind for slot in self.slots.values() if slot.role is Role.OBJECT)

    @property
    def needs_target(self) -> bool:
        """True if a command without a target is not complete."""
        name = self.slot(Role.TARGET)
        return name is not None and self.slots[name].default is None


class VerbsFile(Checked):
    verbs: tuple[Verb, ...] = Field(min_length=1)


@dataclass(frozen=True)
class Verbs:
    """The verbs of one or several files, by word.

    :param origins: word → the file that states it.
    """

    by_word: Mapping[str, Verb]
    origins: Mapping[str, str]

    @classmethod
    def of(cls, verbs: Sequence[Verb], origin: str) -> Self:
        """:raises VerbsError: if two of them have the same word."""
        by_word: dict[str, Verb] = {}
        for verb in verbs:
            for word in verb.words:
                if word in by_word:
                    raise VerbsError(
                        f"{origin}: the word {word!r} is of both {by_word[word].name} and {verb.name}"
                    )
                by_word[word] = verb
        return cls(by_word, dict.fromkeys(by_word, origin))

    @property
    def words(self) -> tuple[str, ...]:
        """All words, in alphabetical order."""
        return tuple(sorted(self.by_word))

    def merged(self, other: "Verbs") -> "Verbs":
        """These verbs and the other's; a word may be in both files only with the same meaning.

        :raises VerbsError: naming the word and both files.
        """
        for word in sorted(self.by_word.keys() & other.by_word.keys()):
            if self.by_word[word] != other.by_word[word]:
                raise VerbsError(
                    f"the word {word!r} is stated by {self.origins[word]} ({self.by_word[word].name}) and by "
                    f"{other.origins[word]} ({other.by_word[word].name}) with different meanings"
                )
        return Verbs({**other.by_word, **self.by_word}, {**other.origins, **self.origins})

    def check_predicates(self, relations: Collection[str]) -> None:
        """Check that every goal is about one of the knowledge base's relations.

        :raises VerbsError: naming the file, the verb, the goal and the choices.
        """
        for word, verb in self.by_word.items():
            for name, call in verb.derived.items():
                if call.name == Function.KNOWN and call.terms[0] not in relations:
                    raise VerbsError(
                        f"{self.origins[word]}: {verb.name}.given.{name}: unknown predicate {call.terms[0]!r}; "
                        f"choices: {', '.join(sorted(relations))}"
                    )
            for index, goal in enumerate(verb.templates):
                if goal.name not in relations:
                    raise VerbsError(
                        f"{self.origins[word]}: {verb.name}.goals.{index}: unknown predicate {goal.name!r}; "
                        f"choices: {', '.join(sorted(relations))}"
                    )


NO_VERBS = Verbs({}, {})


def load_verbs(path: str | Path | None = None) -> Verbs:
    """Read and check a file of verbs; the one that ships with Macta if no path is given.

    :raises VerbsError: naming the file, the line or the slot, and the choices.
    """
    source = resources.files("app.domain.goal_language") / SHIPPED if path is None else Path(path)
    origin = SHIPPED if path is None else str(path)
    try:
        text = source.read_text(encoding="utf-8")
        file = VerbsFile.model_validate(read_yaml(text))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise VerbsError(f"{origin} cannot be read: {error}") from error
    except ValidationError as error:
        slots = [f"  {fault}" for fault in faults_in(text, error)]
        raise VerbsError("\n".join([f"{origin} is not valid:", *slots])) from error
    except ValueError as error:
        raise VerbsError(f"{origin} cannot be read: {error}") from error
    return Verbs.of(file.verbs, origin)


@cache
def shipped_verbs() -> Verbs:
    """The verbs that ship with Macta, read once."""
    return load_verbs()
