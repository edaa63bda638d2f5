"""The behaviours library (MACTA §4, fig. 4): packet tags, indexed by the symbolic goals they achieve."""

import re
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from app.domain.errors import MactaError
from planner import Fact, KnowledgeBase, PlanNetAction
from robots.data import faults_in, place_in, read_yaml

_SHAPE = re.compile(r"^\s*([a-z][a-z0-9_]*)\s*\(([^()]*)\)\s*$")
_TERM = re.compile(r"^\??[A-Za-z][A-Za-z0-9_]*$")

Substitution = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Template:
    """A fact with variables, e.g. `object_position(?object, in, ?ref1)`."""

    predicate: str
    terms: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.terms)})"

    @classmethod
    def parse(cls, text: str) -> "Template":
        """:raises ValueError: if the text is not `predicate(term, …)` with names and ?variables."""
        match = _SHAPE.match(text)
        if match is None:
            raise ValueError(f"{text!r} is not of the form predicate(term, …)")
        terms = tuple(term.strip() for term in match[2].split(","))
        if bad := [term for term in terms if not _TERM.match(term)]:
            raise ValueError(f"{text!r}: {bad[0]!r} is neither a name nor a ?variable")
        return cls(match[1], terms)

    def matched(self, fact: Fact, known: Substitution) -> Substitution | None:
        """`known` extended so that the template equals the fact; None if that is impossible."""
        if fact.predicate != self.predicate or len(fact.args) != len(self.terms):
            return None
        found = dict(known)
        for term, value in zip(self.terms, fact.args, strict=True):
            if (found.setdefault(term, value) if term.startswith("?") else term) != value:
                return None
        return found

    def filled(self, known: Substitution) -> Fact:
        """The fact with names instead of variables."""
        return Fact(self.predicate, tuple(known.get(term, term) for term in self.terms))


def matches(
    templates: Sequence[Template], facts: Sequence[Fact], known: Substitution
) -> Iterator[Substitution]:
    """Every substitution by which the templates equal different facts among `facts`."""
    if not templates:
        yield known
        return
    first, *rest = templates
    for position, fact in enumerate(facts):
        found = first.matched(fact, known)
        if found is not None:
            yield from matches(rest, [*facts[:position], *facts[position + 1 :]], found)


class LibraryError(MactaError):
    """Raised when a behaviours library is not valid; names the packet and the slot."""

    code = "behaviours-library"


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PacketFile(_Part):
    """A packet's entry as written."""

    tag: Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9_]*$")]
    agent: Annotated[str, Field(pattern=r"^\?[a-z][a-z0-9_]*$")]
    requires: tuple[str, ...]
    achieves: tuple[str, ...] = Field(min_length=1)
    when: tuple[str, ...] = ()
    events: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    basic: bool = False
    level: str = ""

    @field_validator("requires", "achieves", "when")
    @classmethod
    def _templates(cls, texts: tuple[str, ...]) -> tuple[str, ...]:
        for text in texts:
            Template.parse(text)
        return texts

    @field_validator("events")
    @classmethod
    def _event_templates(cls, events: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
        for texts in events.values():
            cls._templates(texts)
        return events


class LibraryFile(_Part):
    packets: tuple[PacketFile, ...] = Field(min_length=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A packet: what it requires and what it achieves; `agent` is the variable for the robot itself.

    `when` are facts about the robot and the place that must hold for it to be chosen; the more, the more it is meant
    for them. `events` are facts that hold once the packet has raised an event, by its name. `basic`: every robot can
    carry it out. `level`: its parameter for what a number is to be at its end (`PlanNetAction.level`).
    """

    tag: str
    agent: str
    requires: tuple[Template, ...]
    achieves: tuple[Template, ...]
    when: tuple[Template, ...] = ()
    events: tuple[tuple[str, tuple[Template, ...]], ...] = ()
    basic: bool = False
    level: str = ""

    def fits(self, action: PlanNetAction, agent: str, linking_goals: Sequence[Fact]) -> Substitution | None:
        """The substitution by which the packet is `agent`'s part in the action; None if there is none.

        The packet must achieve every linking goal, and each requirement must be a pre-condition of the action.
        """
        start = {f"?{name}": value for name, value in action.arguments.items()} | {self.agent: agent}
        for found in matches(self.requires, action.preconditions, start):
            widened = self._achieving(linking_goals, found)
            if widened is not None:
                return widened
        return None

    def suited(self, known: Substitution, facts: Collection[Fact]) -> tuple[Fact, ...] | None:
        """The facts for which it is meant; None if one of them does not hold."""
        of_predicates = [fact for fact in facts if any(fact.predicate == one.predicate for one in self.when)]
        found = next(matches(self.when, of_predicates, known), None)
        if found is None:
            return None
        return tuple(one.filled(found) for one in self.when)

    def _achieving(self, goals: Sequence[Fact], known: Substitution) -> Substitution | None:
        if not goals:
            return known
        first, *rest = goals
        for template in self.achieves:
            found = template.matched(first, known)
            widened = None if found is None else self._achieving(rest, found)
            if widened is not None:
                return widened
        return None


class Library:
    """The packets, and an index from the predicates of the goals that they achieve."""

    def __init__(self, entries: Sequence[Entry]) -> None:
        self.entries = tuple(entries)
        index: dict[str, list[Entry]] = defaultdict(list)
        for entry in self.entries:
            for predicate in dict.fromkeys(template.predicate for template in entry.achieves):
                index[predicate].append(entry)
        self.index: Mapping[str, tuple[Entry, ...]] = {name: tuple(found) for name, found in index.items()}

    def achieving(self, goals: Sequence[Fact]) -> tuple[Entry, ...]:
        """The packets that are indexed under every one of the goals' predicates."""
        if not goals:
            return ()
        return tuple(
            entry
            for entry in self.index.get(goals[0].predicate, ())
            if all(entry in self.index.get(goal.predicate, ()) for goal in goals[1:])
        )


def shipped_library() -> Path:
    """The file of the behaviours library that ships with Macta."""
    folder = resources.files("app.domain.mission_organiser")
    with resources.as_file(folder / "behaviours_library.yaml") as path:
        return path


def load_library(
    knowledge_base: KnowledgeBase, *paths: str | Path, tags: Collection[str] | None = None
) -> Library:
    """Read and check the behaviours library that the files make up; the one that ships with Macta if none is given.

    :param tags: of the packets that robots' repertoires have; None: any.
    :raises LibraryError: naming the file, the line, the packet, the slot and the choices.
    """
    entries: dict[Entry, None] = {}
    for path in paths or (shipped_library(),):
        entries |= dict.fromkeys(_entries(path, knowledge_base, tags))
    return Library(tuple(entries))


def _entries(
    path: str | Path, knowledge_base: KnowledgeBase, tags: Collection[str] | None
) -> Iterator[Entry]:
    try:
        text = Path(path).read_text(encoding="utf-8")
        file = LibraryFile.model_validate(read_yaml(text))
    except ValidationError as error:
        slots = [f"  {fault}" for fault in faults_in(text, error)]
        raise LibraryError("\n".join([f"{path} is not a valid behaviours library:", *slots])) from error
    except (OSError, yaml.YAMLError, ValueError) as error:
        raise LibraryError(f"{path} cannot be read as a behaviours library: {error}") from error
    for index, packet in enumerate(file.packets):
        entry = _entry(packet)
        for slot, fault in _faults(entry, knowledge_base, tags):
            where = place_in(text, ("packets", index, *slot), f"{entry.tag}: {fault}")
            raise LibraryError(f"{path} is not a valid behaviours library:\n  {where}")
        yield entry


def _entry(packet: PacketFile) -> Entry:
    return Entry(
        tag=packet.tag,
        agent=packet.agent,
        requires=tuple(map(Template.parse, packet.requires)),
        achieves=tuple(map(Template.parse, packet.achieves)),
        when=tuple(map(Template.parse, packet.when)),
        events=tuple((name, tuple(map(Template.parse, texts))) for name, texts in packet.events.items()),
        basic=packet.basic,
        level=packet.level,
    )


def _faults(
    entry: Entry, knowledge_base: KnowledgeBase, tags: Collection[str] | None
) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Slot and fault of what is not in the knowledge base or the repertoires, and of an agent in no template."""
    if tags is not None and entry.tag not in tags:
        yield (
            ("tag",),
            f"no packet of a repertoire has this tag; choices: {', '.join(sorted(tags)) or 'none'}",
        )
    told = {entry.agent, *(term for one in (*entry.requires, *entry.achieves) for term in one.terms)}
    slots: dict[tuple[str, ...], Sequence[Template]] = {
        ("requires",): entry.requires,
        ("achieves",): entry.achieves,
        ("when",): entry.when,
        **{("events", name): templates for name, templates in entry.events},
    }
    for slot, templates in slots.items():
        for index, template in enumerate(templates):
            if (fault := _misfit(template, knowledge_base)) is not None:
                yield (*slot, index), f"{template}: {fault}"
            elif unknown := [term for term in template.terms if term.startswith("?") and term not in told]:
                choices = ", ".join(sorted(term for term in told if term.startswith("?")))
                yield (
                    (*slot, index),
                    f"{template}: {unknown[0]} is in no fact that it requires or achieves; choices: {choices}",
                )
    if all(entry.agent not in template.terms for template in (*entry.requires, *entry.achieves)):
        yield ("agent",), f"{entry.agent} is in none of its templates"


def _misfit(template: Template, knowledge_base: KnowledgeBase) -> str | None:
    predicate = knowledge_base.predicates.get(template.predicate)
    if predicate is None:
        choices = ", ".join(sorted(knowledge_base.predicates))
        return f"unknown predicate {template.predicate!r}; choices: {choices}"
    if len(template.terms) != len(predicate.arguments):
        return f"{template.predicate} takes ({', '.join(predicate.arguments)})"
    for term in template.terms:
        if not term.startswith("?") and term not in knowledge_base.constants:
            choices = ", ".join(sorted(knowledge_base.constants))
            return f"unknown name {term!r}; choices: {choices}"
    return None
