"""What the phrases of a sentence name in a world: samples, robots, places, and sets of them."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.constraints import NOTHING_WITHHELD, AppliedConstraints
from app.domain.goal_language.issues import unknown_name
from app.domain.goal_language.reachability import free_for, is_long
from app.domain.goal_language.roles import players_of
from app.domain.goal_language.sentence import Phrase, Quantity
from app.domain.goal_language.syntax import AFTER_NAME, grammar
from app.domain.goal_language.verbs import NO_VERBS, Kind
from app.domain.goal_language.words import joined, name_in, natural_key
from app.domain.world_model.beliefs import NEAR, REACHES, ROBOT_POSITION, Facts, occupants, place_of
from app.domain.world_model.berths import berths_of
from robots.wire import SymbolicFact
from robots.world import WorldFile
from robots.world.parts import Aisle, Rectangle

PRONOUNS = frozenset({(), ("sample",), ("it",), ("one",)})
"""Words for a sample that is told by where it lies."""
PARKING_KINDS = ("home", "place", "dock")
"""Kinds of locations where a robot without a home may be parked, the first choice first."""
LONG = "long"
Aims = Callable[[], Collection[SymbolicFact]]
"""What goals beside the sentence are to make true."""


def no_aims() -> Collection[SymbolicFact]:
    return ()


def locations_aimed_at(goals: Iterable[SymbolicFact], thing: str, world: WorldFile) -> list[str]:
    """The locations that goals aim at for other things than this one, each as often as it is."""
    aims = [goal.args[-1] for goal in goals if goal.args and thing not in goal.args]
    return [world.location_of.get(aim, aim) for aim in aims]


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Where things are said to be: a location, a berth, an aisle, a compartment or a zone.

    :param places: its places.
    """

    name: str
    places: tuple[str, ...]
    is_area: bool = False


@dataclass(slots=True, kw_only=True)
class References:
    """Resolves the phrases of one sentence.

    :param mentioned: the samples and robots that the sentence has named so far.
    :param roles: those by which the sentence has named all robots that play them.
    :param settled: samples that are already where the command brings them; a number of samples means others.
    :param applied: the constraints within which a free place, or one of several things, is chosen.
    """

    world: WorldFile
    facts: Facts
    mentioned: set[str] = field(default_factory=set)
    roles: dict[str, tuple[str, ...]] = field(default_factory=dict)
    settled: frozenset[str] = frozenset()
    applied: AppliedConstraints = NOTHING_WITHHELD

    @property
    def samples(self) -> tuple[str, ...]:
        return _sorted(sample.name for sample in self.world.samples)

    @property
    def robots(self) -> tuple[str, ...]:
        return _sorted(robot.name for robot in self.world.robots)

    @property
    def locations(self) -> tuple[str, ...]:
        return _sorted(self.world.places_by_location)

    def holding(self) -> tuple[str, ...]:
        """The locations that hold samples."""
        return _sorted(place.name for place in self.world.locations if place.capacity > 0)

    def place(self, phrase: Phrase, choices: Sequence[str] = ()) -> str | Clarification:
        """The location or berth of that name.

        :param choices: those to offer; default: the locations that hold samples.
        """
        names = (*self.world.places_by_location, *self.world.location_of)
        name = name_in(phrase.words, names)
        if (area := self._area(phrase)) is not None:
            holding = tuple(one for one in self._locations_in(area) if one in self.holding())
            return Clarification(
                code="unknown-place",
                detail=f"{area.name} is an area, not a place; say any place of {area.name}, or one of its places",
                thing=phrase.said,
                choices=(f"any place of {area.name}", *holding),
                span=phrase.span,
            )
        if name not in names or phrase.quantity is not Quantity.NAMED:
            return unknown("place", name, choices or self.holding(), phrase)
        whole = self.whole_of(phrase)
        if isinstance(whole, Clarification):
            return whole
        if whole is not None and not {name, *berths_of(name, self.world)} & {whole.name, *whole.places}:
            return Clarification(
                code="unknown-place",
                detail=f"{name} is not in {whole.name}",
                thing=name,
                choices=self._locations_in(whole),
                span=phrase.span,
            )
        return name

    def whole_of(self, phrase: Phrase) -> Origin | Clarification | None:
        """What follows "of" in a phrase: "every bay of aisle_1"."""
        whole = phrase.of_whole()
        return None if whole is None else self.origin(whole)

    def _locations_in(self, origin: Origin) -> tuple[str, ...]:
        return _sorted({self.world.location_of[place] for place in origin.places})

    def origin(self, phrase: Phrase) -> Origin | Clarification:
        """Where things are said to be."""
        area = self._area(phrase)
        if area is not None:
            return area
        place = self.place(phrase, (*self.holding(), *self._areas()))
        if isinstance(place, Clarification):
            return place
        return Origin(name=place, places=berths_of(place, self.world) or (place,))

    def _areas(self) -> dict[str, Aisle | Rectangle]:
        """The compartments, their aisles and the zones, by name."""
        areas: list[Aisle | Rectangle] = [
            area for compartment in self.world.compartments for area in (compartment, *compartment.aisles)
        ]
        return {area.name: area for area in [*areas, *self.world.zones]}

    def _area(self, phrase: Phrase) -> Origin | None:
        """The area of that name with its places; None if the phrase names none."""
        areas = self._areas()
        name = name_in(phrase.words, areas)
        if name not in areas or phrase.quantity is not Quantity.NAMED:
            return None
        inside = tuple(place.name for place in self.world.places if areas[name].contains(place.at))
        return Origin(name=name, places=inside, is_area=True)

    def things(
        self, kind: Kind, phrase: Phrase, verb: str, origin: Origin | None
    ) -> tuple[str, ...] | Clarification:
        """The samples, robots or locations that a phrase means.

        :param origin: where they are said to be, if the phrase itself does not say it.
        """
        whole = self.whole_of(phrase)
        if isinstance(whole, Clarification):
            return whole
        origin = whole or origin
        match kind:
            case Kind.SAMPLE:
                found = self._samples_of(phrase, verb, origin)
            case Kind.ROBOT:
                found = self._robots_of(phrase, verb, origin)
            case Kind.PLACE:
                found = self._places_of(phrase, verb, origin)
        if isinstance(found, Clarification):
            return found
        if kind is Kind.SAMPLE and whole is not None:
            asked = self.elsewhere(found, whole, phrase)
            if asked is not None:
                return asked
        self.mentioned.update(found)
        return found

    def elsewhere(self, samples: Sequence[str], origin: Origin, phrase: Phrase) -> Clarification | None:
        """The question if a sample is not where it is said to lie."""
        for sample in samples if self.facts else ():
            lies = place_of(sample, self.facts)
            if lies not in {origin.name, *origin.places}:
                where = f"in {lies}" if lies else "in an unknown place"
                return Clarification(
                    code="sample-elsewhere",
                    detail=f"{sample} is {where}, not in {origin.name}",
                    thing=sample,
                    choices=(lies,) if lies else (),
                    span=phrase.span,
                )
        return None

    def _samples_of(
        self, phrase: Phrase, verb: str, origin: Origin | None
    ) -> tuple[str, ...] | Clarification:
        names = self.samples
        if phrase.quantity is Quantity.NAMED and phrase.words in PRONOUNS:
            there = self._lying(origin)
            if len(there) == 1:
                return there
            nothing = origin is not None and self.facts and not there
            detail = f"no sample lies in {origin.name}" if origin and nothing else f"{verb} which sample?"
            return Clarification(
                code="sample-needed", detail=detail, choices=there or names, span=phrase.span
            )
        if (several := _noun(phrase, "sample", {LONG})) is not None:
            fitting = self._lying(origin) if origin else names
            if LONG in several:
                fitting = tuple(name for name in fitting if is_long(name, self.world))
            where = f" in {origin.name}" if origin else ""
            return self._quantified(phrase, fitting, "sample", where)
        return _named("sample", phrase, names, self.robots, "is a robot; goals name samples")

    def _lying(self, origin: Origin | None) -> tuple[str, ...]:
        """The samples that lie there; empty if no place is said."""
        places = () if origin is None else origin.places
        return _sorted(sample for place in places for sample in occupants(place, self.facts))

    def _robots_of(self, phrase: Phrase, verb: str, origin: Origin | None) -> tuple[str, ...] | Clarification:
        names = self.robots
        if phrase.quantity is Quantity.NAMED and phrase.words in {(), ("robot",), ("it",)}:
            return Clarification(
                code="robot-needed", detail=f"{verb} which robot?", choices=names, span=phrase.span
            )
        if _noun(phrase, "robot", ()) is not None:
            fitting = names if origin is None else self._robots_in(origin)
            return self._quantified(phrase, fitting, "robot", f" in {origin.name}" if origin else "")
        if name_in(phrase.words, names) not in names and (role := self._role_of(phrase)) is not None:
            return self._players(phrase, *role, origin)
        return _named("robot", phrase, names, self.samples, f"is a sample; {verb!r} takes robots")

    def _role_of(self, phrase: Phrase) -> tuple[str, bool] | None:
        """The role that a phrase like "the guard" or "all guards" names, and whether in the plural; None if none."""
        roles = players_of(self.world)
        *before, last = phrase.words
        for words, is_plural in ((phrase.words, False), ((*before, last.removesuffix("s")), True)):
            if (role := name_in(words, roles)) in roles:
                return role, is_plural
        return None

    def _players(
        self, phrase: Phrase, role: str, is_plural: bool, origin: Origin | None
    ) -> tuple[str, ...] | Clarification:
        """The robots that play a role, as many as the phrase says."""
        players = players_of(self.world)[role]
        fitting = [name for name in players if origin is None or name in self._robots_in(origin)]
        where = f" in {origin.name}" if origin else ""
        if phrase.quantity is Quantity.NAMED and not is_plural and len(fitting) > 1:
            detail = f"which {role}? There are {len(fitting)}{where}: {joined(fitting, last='and')}"
            return Clarification(
                code="robot-needed",
                detail=detail,
                thing=phrase.said,
                choices=tuple(fitting),
                span=phrase.span,
            )
        found = self._quantified(phrase, fitting, role, where, code="robot-needed")
        if found == players and phrase.quantity in (Quantity.NAMED, Quantity.ALL):
            self.roles[role] = players
        return found

    def kind_of(self, phrase: Phrase) -> Kind | None:
        """Whether a phrase names samples or robots; None if neither."""
        if name_in(phrase.words, self.samples) in self.samples or _noun(phrase, "sample", {LONG}) is not None:
            return Kind.SAMPLE if phrase.words else None
        if name_in(phrase.words, self.robots) in self.robots or _noun(phrase, "robot", ()) is not None:
            return Kind.ROBOT
        return Kind.ROBOT if phrase.words and self._role_of(phrase) is not None else None

    def _robots_in(self, origin: Origin) -> tuple[str, ...]:
        """The robots of that compartment or aisle, or those that stand at the place."""
        standing = {
            f.args[0] for f in self.facts if f.predicate == ROBOT_POSITION and f.args[2] in origin.places
        }
        return tuple(
            name
            for name in self.robots
            if name in standing
            or (origin.is_area and origin.name in {(spec := self.world.robot(name)).compartment, spec.aisle})
        )

    def _places_of(self, phrase: Phrase, verb: str, origin: Origin | None) -> tuple[str, ...] | Clarification:
        if not phrase.words and phrase.quantity is Quantity.NAMED:
            choices = self.locations
            return Clarification(
                code="place-needed", detail=f"{verb} which place?", choices=choices, span=phrase.span
            )
        inside = self.locations if origin is None else self._locations_in(origin)
        if (kind := self.kind_of_place(phrase)) is not None:
            fitting = tuple(name for name in inside if kind in ("", self.world.location(name).kind))
            where = f" in {origin.name}" if origin else ""
            return self._quantified(phrase, fitting, kind or "place", where)
        if origin is None and (area := self._area(phrase)) is not None:
            return self._locations_in(area)
        place = self.place(phrase, (*self.locations, *self._areas()) if origin is None else self.locations)
        return place if isinstance(place, Clarification) else (place,)

    def lying_in(self, location: str) -> frozenset[str]:
        """The samples that lie in the location or one of its berths."""
        places = berths_of(location, self.world) or (location,)
        return frozenset(sample for place in places for sample in occupants(place, self.facts))

    def kind_of_place(self, phrase: Phrase) -> str | None:
        """The kind of location that a phrase like "all bays" names; "" for any kind, None if it names no kind."""
        if _noun(phrase, "place", ()) is not None or _noun(phrase, "location", ()) is not None:
            return ""
        kinds = sorted({location.kind for location in self.world.locations})
        return next((kind for kind in kinds if _noun(phrase, kind, {"free"}) is not None), None)

    def _quantified(
        self, phrase: Phrase, fitting: Sequence[str], what: str, where: str, *, code: str = ""
    ) -> tuple[str, ...] | Clarification:
        """As many of the fitting names as the phrase says."""
        left = tuple(name for name in fitting if name not in self.mentioned)
        code = code or f"{what if what in list(Kind) else 'place'}-needed"
        match phrase.quantity:
            case Quantity.OTHER:
                found = left
                wanted = phrase.count or (1 if _is_singular(phrase, what) else len(left))
            case Quantity.COUNT:
                left = tuple(name for name in left if name not in self.settled)
                found = self._permitted_first(left)[: phrase.count]
                wanted = phrase.count
            case Quantity.ANY:
                found = self._permitted_first(left)[:1]
                wanted = 1
            case _:
                found = tuple(fitting)
                wanted = len(found)
        if found and len(found) == wanted:
            return found
        if not found and phrase.quantity is not Quantity.COUNT:
            other = "other " if phrase.quantity is Quantity.OTHER else ""
            detail = f"there is no {other}{what}{where}"
        elif len(found) > wanted:
            detail = f"which {what}? There are {len(found)}{where}: {joined(found, last='and')}"
        else:
            detail = f"{wanted} {what}s are asked for, there are {len(left)}{where}"
        return Clarification(
            code=code, detail=detail, thing=phrase.said, choices=left or tuple(fitting), span=phrase.span
        )

    def _permitted_first(self, names: Sequence[str]) -> tuple[str, ...]:
        """The names, last the robots and samples to leave alone, and what lies in a place that is to be avoided."""
        applied = self.applied

        def is_withheld(name: str) -> bool:
            return name in applied.excluded | applied.kept_samples or not applied.avoided.isdisjoint(
                {name, *berths_of(name, self.world), place_of(name, self.facts)}
            )

        return tuple(sorted(names, key=is_withheld))

    def free_place(self, phrase: Phrase, kind: str, thing: str, taken: Sequence[str]) -> str | Clarification:
        """A free location of a kind for a sample or robot, one that no other goal aims at.

        :param taken: the locations that other goals aim at, each as often as it is.
        """
        closed = self.applied.avoided
        if thing in self.robots:
            near = {f.args[2] for f in self.facts if f.predicate == ROBOT_POSITION and f.args[1] == NEAR}
            free = [place for place in self.reached_by(thing) if place not in near]
        else:
            closed |= self.applied.closed
            left = self.applied.applied_to(self.facts)
            free = [place for place in free_for(thing, self.world, left) if place not in closed]
        whole = self.whole_of(phrase)
        if isinstance(whole, Clarification):
            return whole
        inside = self.locations if whole is None else self._locations_in(whole)
        fitting = [name for name in free if name in inside and kind in ("", self.world.location(name).kind)]
        for name in fitting:
            if list(taken).count(name) < self._room(name, closed, holds_samples=thing not in self.robots):
                return name
        aims = [name for name in fitting if name in taken]
        why = f": goals aim at {joined(aims, last='and')} already" if aims else ""
        return Clarification(
            code="place-needed",
            detail=f"there is no free {kind or 'place'}{f' in {whole.name}' if whole else ''} for {thing}{why}",
            thing=phrase.said,
            choices=tuple(name for name in free if name not in taken),
            span=phrase.span,
        )

    def _room(self, location: str, closed: Collection[str], *, holds_samples: bool) -> int:
        """How many more samples fit in the location now; else how many robots can stand near it."""
        places = [place for place in berths_of(location, self.world) or (location,) if place not in closed]
        return sum(not (holds_samples and occupants(place, self.facts)) for place in places)

    def reached_by(self, robot: str) -> tuple[str, ...]:
        """The locations that the robot reaches."""
        reached = {f.args[1] for f in self.facts if f.predicate == REACHES and f.args[0] == robot}
        if not self.facts:
            reached = {place.name for place in self.world.reach_of(self.world.robot(robot))}
        return _sorted({self.world.location_of.get(place, place) for place in reached})

    def parking_of(self, robot: str, aimed_at: Collection[str]) -> str | Clarification:
        """The robot's home; without one, a free parking place that it reaches.

        :param aimed_at: the locations that other robots are to be parked at.
        """
        home = self.world.robot(robot).home
        if home is not None:
            return home
        reached = self.reached_by(robot)
        taken = self._taken_for(robot).union(aimed_at)
        for kind in PARKING_KINDS:
            for place in reached:
                if self.world.location(place).kind == kind and place not in taken:
                    return place
        return Clarification(
            code="place-needed",
            detail=f"{robot} has no home, and no parking place that it reaches is free; say where to park it",
            thing=robot,
            choices=reached,
        )

    def charger_of(self, robot: str, aimed_at: Sequence[str]) -> str | Clarification:
        """The robot's home; without one, a charger that it reaches: one that no other robot stands at, if there is one,
        and that the fewest others are to be charged at.

        :param aimed_at: the locations that other robots are to be charged at, each as often as it is.
        """
        spec = self.world.robot(robot)
        if spec.home is not None:
            return spec.home
        reached = self.reached_by(robot)
        chargers = [place.name for place in self.world.chargers_of(spec) if place.name in reached]
        taken = self._taken_for(robot)
        if chargers:
            return min(chargers, key=lambda one: (one in taken, aimed_at.count(one), natural_key(one)))
        return Clarification(
            code="place-needed",
            detail=f"{robot} has no home and reaches no charger; say where to charge it",
            thing=robot,
            choices=reached,
        )

    def _taken_for(self, robot: str) -> frozenset[str]:
        """The places where others stand, and those to be avoided."""
        stands = {f.args[2] for f in self.facts if f.predicate == ROBOT_POSITION and f.args[0] != robot}
        return frozenset(stands) | self.applied.avoided

    def known(self, predicate: str, first: Sequence[str]) -> str | Clarification:
        """The last argument of the fact of the predicate that begins with these; of several, the first by name."""
        found = {
            fact.args[-1]
            for fact in self.facts
            if fact.predicate == predicate and list(fact.args[:-1]) == list(first)
        }
        if found:
            return _sorted(found)[0]
        about = f" of {joined(first, last='and')}" if first else ""
        return Clarification(
            code="fact-needed", detail=f"no fact {predicate!r}{about} is known in {self.world.name}"
        )

    def lying_place(self, sample: str) -> str | Clarification:
        """Where the sample lies."""
        place = place_of(sample, self.facts)
        if place is None:
            return Clarification(
                code="sample-lost", detail=f"it is not known where {sample} is", thing=sample
            )
        if place in self.robots:
            return Clarification(
                code="sample-elsewhere",
                detail=f"{sample} is held by {place}, it lies in no place",
                thing=sample,
            )
        return place


def _named(
    what: str, phrase: Phrase, names: tuple[str, ...], others: Sequence[str], instead: str
) -> tuple[str, ...] | Clarification:
    """The one thing that the phrase names.

    :param others: names of things of another kind.
    :param instead: what to say of one of them.
    """
    name = name_in(phrase.words, names)
    if name in names:
        return (name,)
    if name in others:
        return Clarification(
            code=f"unknown-{what}", detail=f"{name} {instead}", thing=name, choices=names, span=phrase.span
        )
    return unknown(what, name, names, phrase)


def unknown(what: str, name: str, names: Sequence[str], phrase: Phrase) -> Clarification:
    """The question about a name that the world does not have."""
    start = _known_start(what, names, phrase)
    if start:
        rest = phrase.words[start]
        return Clarification(
            code="goal-not-understood",
            detail=f"{rest!r} is not understood here, after {' '.join(phrase.words[:start])}",
            thing=rest,
            choices=grammar().words_for(AFTER_NAME, NO_VERBS),
            span=phrase.word_spans[start],
        )
    issue = unknown_name(what, name, names)
    return Clarification(
        code=issue.code, detail=issue.detail, thing=name, choices=issue.choices, span=phrase.span
    )


def _known_start(what: str, names: Sequence[str], phrase: Phrase) -> int:
    """The number of words with which the phrase begins that are a name or a kind without the others; 0 if none."""
    for end in range(len(phrase.words) - 1, 0, -1):
        words = phrase.words[:end]
        if phrase.quantity is Quantity.NAMED:
            is_known = name_in(words, names) in names
        else:
            is_known = words in {(what,), (f"{what}s",)}
        if is_known:
            return end
    return 0


def _noun(phrase: Phrase, noun: str, adjectives: Iterable[str]) -> tuple[str, ...] | None:
    """The adjectives before a noun that says a kind, not a name; None if the phrase is a name."""
    *before, last = phrase.words or ("",)
    if any(word not in set(adjectives) for word in before):
        return None
    if last == "" or last in {"one", "ones"}:
        is_kind = phrase.quantity is not Quantity.NAMED
    else:
        is_kind = last == f"{noun}s" or (
            last == noun and (phrase.quantity is not Quantity.NAMED or bool(before))
        )
    return tuple(before) if is_kind else None


def _is_singular(phrase: Phrase, noun: str) -> bool:
    return phrase.words[-1:] in {(noun,), ("one",)}


def _sorted(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(names, key=natural_key))
