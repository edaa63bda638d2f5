"""The grammar of goals (MACTA §4: "move rock_sample to lander").

    goal   = clause { ("and" | "," | ";" | "then") clause }
    clause = [ verb ] sample [ "from" place ] ("to" | "in" | "into" | "at" | "on") place [ "from" place ]
    verb   = "move" | "take" | "bring" | "store" | "put" | "deliver" | "retrieve" | "carry" | "fetch" | …

A later clause may leave out the verb. Case, articles and hyphens do not matter; `sample 3` is `sample_3`. The
sample may also be named by where it lies: "store the sample at door_1 in bay_7".
"""

from collections.abc import Sequence
from dataclasses import dataclass

from app.domain.goal_language.reachability import free_places
from app.domain.goal_language.words import choices_for, joined, name_in, natural_key, suggestions, words_of
from app.domain.world_model.beliefs import IN, Facts, occupants, place_of
from app.domain.world_model.berths import berths_of
from robots.wire import SymbolicFact
from robots.world import WorldFile

VERBS = frozenset(
    {"move", "take", "bring", "store", "put", "deliver", "retrieve", "carry", "fetch", "return"}
)
TARGETS = frozenset({"to", "in", "into", "at", "on", "onto"})
ORIGINS = frozenset({"from"})
JOINTS = frozenset({"and", "then"})
FILLERS = frozenset({"please", "back", "now", "over"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Clarification:
    """What is missing or not understood in a sentence.

    :param thing: the word in question.
    :param choices: words that would be understood.
    """

    code: str
    detail: str
    thing: str = ""
    choices: tuple[str, ...] = ()


Parsed = tuple[SymbolicFact, ...] | Clarification


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause:
    """A clause cut into its parts; the parts are still words."""

    verb: str
    sample: tuple[str, ...]
    target: tuple[str, ...]
    origin: tuple[str, ...]


def parse_goal(text: str, world: WorldFile, facts: Facts = frozenset()) -> Parsed:
    """The goals of a sentence, in rel/ref form, or what to ask the operator.

    :param facts: where samples are believed to be, for "from" and for samples named by their place.
    """
    clauses = _clauses(text)
    if not clauses:
        return Clarification(
            code="goal-not-understood",
            detail='say what to move and where to, e.g. "move sample_1 to bay_7"',
            choices=_samples(world),
        )
    goals: list[SymbolicFact] = []
    verb = ""
    for words in clauses:
        clause = _cut(words, verb)
        if isinstance(clause, Clarification):
            return clause
        verb = clause.verb
        goal = _goal(clause, world, facts)
        if isinstance(goal, Clarification):
            return goal
        goals.append(goal)
    return tuple(goals)


def _clauses(text: str) -> list[tuple[str, ...]]:
    spaced = text.replace(",", " and ").replace(";", " and ")
    clauses: list[list[str]] = [[]]
    for word in words_of(spaced):
        if word in JOINTS:
            clauses.append([])
        elif word not in FILLERS:
            clauses[-1].append(word)
    return [tuple(clause) for clause in clauses if clause]


def _cut(words: tuple[str, ...], verb: str) -> Clause | Clarification:
    """Cut a clause at its prepositions; a clause without a verb has that of the clause before, `verb`."""
    if words[0] in VERBS:
        verb = words[0]
        words = words[1:]
    if not verb:
        verbs = tuple(sorted(VERBS))
        near = suggestions(words[0], verbs)
        detail = f"{words[0]!r} is not a known verb" + (f"; did you mean {joined(near)}?" if near else "")
        return Clarification(code="unknown-verb", detail=detail, thing=words[0], choices=near or verbs)
    parts: list[tuple[str, list[str]]] = [("", [])]
    for word in words:
        if word in TARGETS | ORIGINS:
            parts.append((word, []))
        else:
            parts[-1][1].append(word)
    return _arranged(verb, [(preposition, tuple(part)) for preposition, part in parts])


def _arranged(verb: str, parts: Sequence[tuple[str, tuple[str, ...]]]) -> Clause | Clarification:
    """Assign the parts their roles. Of two targets the first is where the sample lies: "the one at door_1"."""
    sample = parts[0][1]
    targets = [part for preposition, part in parts[1:] if preposition in TARGETS]
    origins = [part for preposition, part in parts[1:] if preposition in ORIGINS]
    if len(targets) == 2 and not origins:
        origins = targets[:1]
        targets = targets[1:]
    if len(targets) > 1 or len(origins) > 1:
        said = " ".join(" ".join((preposition, *part)).strip() for preposition, part in parts)
        return Clarification(
            code="goal-not-understood",
            detail=f"{verb} {said!r} names too many places; say one from and one to",
        )
    return Clause(
        verb=verb,
        sample=sample,
        target=targets[0] if targets else (),
        origin=origins[0] if origins else (),
    )


def _goal(clause: Clause, world: WorldFile, facts: Facts) -> SymbolicFact | Clarification:
    origin = _place(clause.origin, world) if clause.origin else None
    if isinstance(origin, Clarification):
        return origin
    sample = _sample(clause, origin, world, facts)
    if isinstance(sample, Clarification):
        return sample
    if not clause.target:
        return _where_to(clause, sample, world, facts)
    place = _place(clause.target, world)
    if isinstance(place, Clarification):
        return place
    lies = place_of(sample, facts)
    if origin is not None and facts and lies not in {origin, *berths_of(origin, world)}:
        where = f"in {lies}" if lies else "in an unknown place"
        return Clarification(
            code="sample-elsewhere",
            detail=f"{sample} is {where}, not in {origin}",
            thing=sample,
            choices=(lies,) if lies else (),
        )
    return SymbolicFact(predicate=IN, args=(sample, place))


def _sample(clause: Clause, origin: str | None, world: WorldFile, facts: Facts) -> str | Clarification:
    names = _samples(world)
    if clause.sample in {(), ("sample",), ("it",), ("one",)}:
        places = () if origin is None else (berths_of(origin, world) or (origin,))
        there = tuple(sample for place in places for sample in occupants(place, facts))
        if len(there) == 1:
            return there[0]
        nothing = origin and facts and not there
        detail = f"no sample lies in {origin}" if nothing else f"{clause.verb} which sample?"
        return Clarification(code="sample-needed", detail=detail, choices=there or names)
    name = name_in(clause.sample, names)
    if name in names:
        return name
    if any(robot.name == name for robot in world.robots):
        detail = f"{name} is a robot; goals name samples"
        return Clarification(code="unknown-sample", detail=detail, thing=name, choices=names)
    return _unknown("sample", name, names)


def _place(words: tuple[str, ...], world: WorldFile) -> str | Clarification:
    names = (*world.places_by_location, *world.location_of)
    name = name_in(words, names)
    if name in names:
        return name
    holding = tuple(sorted((p.name for p in world.locations if p.capacity > 0), key=natural_key))
    return _unknown("place", name, holding)


def _unknown(what: str, name: str, names: Sequence[str]) -> Clarification:
    near = suggestions(name, names)
    hint = f"; did you mean {joined(near)}?" if near else ""
    return Clarification(
        code=f"unknown-{what}",
        detail=f"there is no {what} {name!r}{hint}",
        thing=name,
        choices=choices_for(name, names),
    )


def _where_to(clause: Clause, sample: str, world: WorldFile, facts: Facts) -> Clarification:
    """Ask for the place, the likely ones first: bays to store in, doors to bring samples to."""
    likely = {"store": "bay", "retrieve": "door", "deliver": "door", "fetch": "door"}.get(clause.verb)
    free = {world.location_of[place] for place in free_places(world, facts)}
    choices = tuple(sorted(free, key=lambda name: (world.location(name).kind != likely, natural_key(name))))
    return Clarification(
        code="place-needed",
        detail=f"{clause.verb} {sample} where to?",
        thing=sample,
        choices=choices,
    )


def _samples(world: WorldFile) -> tuple[str, ...]:
    return tuple(sorted((sample.name for sample in world.samples), key=natural_key))
