"""The behaviours library (MACTA §4, fig. 4): packet tags, indexed by the symbolic goals they achieve."""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from app.domain.errors import MactaError
from planner import Fact, KnowledgeBase, PlanNetAction
from robots.data import read_yaml

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

    @field_validator("requires", "achieves")
    @classmethod
    def _templates(cls, texts: tuple[str, ...]) -> tuple[str, ...]:
        for text in texts:
            Template.parse(text)
        return texts


class LibraryFile(_Part):
    packets: tuple[PacketFile, ...] = Field(min_length=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A packet: what it requires and what it achieves; `agent` is the variable for the robot itself."""

    tag: str
    agent: str
    requires: tuple[Template, ...]
    achieves: tuple[Template, ...]

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


def load_library(knowledge_base: KnowledgeBase, path: str | Path | None = None) -> Library:
    """Read and check a behaviours library; the one that ships with Macta if no path is given.

    :raises LibraryError: naming the file, the packet, the slot and the choices.
    """
    source = (
        resources.files("app.domain.mission_organiser") / "behaviours_library.yaml"
        if path is None
        else Path(path)
    )
    origin = "behaviours library" if path is None else str(path)
    try:
        file = LibraryFile.model_validate(read_yaml(source.read_text()))
    except (OSError, yaml.YAMLError) as error:
        raise LibraryError(f"{origin} cannot be read: {error}") from error
    except ValidationError as error:
        slots = [f"  {'.'.join(map(str, e['loc'])) or 'library'}: {e['msg']}" for e in error.errors()]
        raise LibraryError("\n".join([f"{origin} is not valid:", *slots])) from error
    entries = [_entry(packet) for packet in file.packets]
    for entry in entries:
        _check(entry, knowledge_base, origin)
    return Library(entries)


def _entry(packet: PacketFile) -> Entry:
    return Entry(
        tag=packet.tag,
        agent=packet.agent,
        requires=tuple(map(Template.parse, packet.requires)),
        achieves=tuple(map(Template.parse, packet.achieves)),
    )


def _check(entry: Entry, knowledge_base: KnowledgeBase, origin: str) -> None:
    """Check that the entry names only predicates and constants of the knowledge base, and uses its agent variable.

    :raises LibraryError: if not.
    """
    for slot, templates in (("requires", entry.requires), ("achieves", entry.achieves)):
        for template in templates:
            where = f"{origin}: {entry.tag}.{slot}: {template}"
            predicate = knowledge_base.predicates.get(template.predicate)
            if predicate is None:
                choices = ", ".join(sorted(knowledge_base.predicates))
                raise LibraryError(f"{where}: unknown predicate {template.predicate!r}; choices: {choices}")
            if len(template.terms) != len(predicate.arguments):
                raise LibraryError(f"{where}: {template.predicate} takes ({', '.join(predicate.arguments)})")
            for term in template.terms:
                if not term.startswith("?") and term not in knowledge_base.constants:
                    choices = ", ".join(sorted(knowledge_base.constants))
                    raise LibraryError(f"{where}: unknown name {term!r}; choices: {choices}")
    if all(entry.agent not in template.terms for template in (*entry.requires, *entry.achieves)):
        raise LibraryError(f"{origin}: {entry.tag}.agent: {entry.agent} is in none of its templates")
