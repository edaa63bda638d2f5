"""What a sentence says: goals, constraints and a deadline, or what to ask the operator.

The grammar is in `goals.lark`, what its verbs mean in `verbs.yaml`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cache
from itertools import product

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.commands import commands_of
from app.domain.goal_language.constraints import (
    DEFAULT_COST_S,
    MAX_WORTH,
    NOTHING_WITHHELD,
    UNCONSTRAINED,
    Constraints,
    StatedPreference,
)
from app.domain.goal_language.hold_ends import hold_end
from app.domain.goal_language.kept_facts import HoldFact
from app.domain.goal_language.reachability import free_places
from app.domain.goal_language.references import Aims, Origin, References, locations_aimed_at, no_aims
from app.domain.goal_language.roles import Players, with_roles
from app.domain.goal_language.sentence import ENDS, Clause, Part, Phrase, Quantity, Tail
from app.domain.goal_language.stated_holds import HoldEnd, StatedHold, kept_by
from app.domain.goal_language.syntax import parse
from app.domain.goal_language.terms import Reading
from app.domain.goal_language.times import Due, Goals, Missions, Times, no_goals, no_missions
from app.domain.goal_language.verbs import Call, Function, Kind, Role, Slot, Verb, Verbs, shipped_verbs
from app.domain.goal_language.words import joined, natural_key
from app.domain.world_model.beliefs import IN, NEAR, Facts
from app.domain.world_model.berths import berths_of, interchanges
from robots.wire import SymbolicFact
from robots.world import WorldFile

__all__ = ["Clarification", "Parsed", "Understood", "parse_goal", "understand"]

MAX_GOALS = 100
"""The most goals of one sentence."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Understood:
    """What a sentence asks for.

    :param goals: in rel/ref form.
    :param readings: what its quantities, choices and times were resolved to.
    """

    goals: tuple[SymbolicFact, ...]
    constraints: Constraints = UNCONSTRAINED
    due: Due | None = None
    readings: tuple[Reading, ...] = ()
    holds: tuple[StatedHold, ...] = ()


Parsed = tuple[SymbolicFact, ...] | Clarification


def parse_goal(text: str, world: WorldFile, facts: Facts = frozenset(), verbs: Verbs | None = None) -> Parsed:
    """The goals of a sentence, in rel/ref form, or what to ask the operator.

    :param facts: where samples are believed to be, for "from" and for samples named by their place.
    """
    understood = understand(text, world, facts, verbs=verbs)
    return understood if isinstance(understood, Clarification) else understood.goals


def understand(
    text: str,
    world: WorldFile,
    facts: Facts = frozenset(),
    *,
    verbs: Verbs | None = None,
    now: datetime | None = None,
    missions: Missions = no_missions,
    goals: Goals = no_goals,
    beside: Constraints = UNCONSTRAINED,
    aims: Aims = no_aims,
) -> Understood | Clarification:
    """What a sentence asks for, or what to ask the operator.

    :param verbs: by default those that ship with Macta.
    :param now: the service's time in its time zone, for times of day; None: they are not understood.
    :param missions: called if the sentence names a mission; `goals`: if it names a goal.
    :param beside: constraints given beside the sentence; what the sentence leaves open is chosen within them.
    :param aims: called if the sentence leaves a place open: "any bay" is none that another goal aims at.
    """
    known = shipped_verbs() if verbs is None else verbs
    times = Times(now, missions, goals)
    aims = cache(aims)
    first = _read(text, known, References(world=world, facts=facts), times, aims)
    if isinstance(first, Clarification):
        return first
    within = first.constraints.of_robots(world).and_also(beside.of_robots(world))
    required = within.and_also(kept_by(first.holds))
    preferred = Constraints.all_of(
        (required, *(preference.constraint.of_robots(world) for preference in within.preferences))
    )
    # Constraints may stand after the choices that they limit: read again, with all of them known; with the preferences
    # if all of them can be kept.
    for limits in (preferred, required):
        applied = limits.in_world(world)
        if applied == NOTHING_WITHHELD:
            return first
        again = _read(text, known, References(world=world, facts=facts, applied=applied), times, aims)
        if not isinstance(again, Clarification):
            return again
    return first


def _read(text: str, verbs: Verbs, names: References, times: Times, aims: Aims) -> Understood | Clarification:
    progress = parse(text, verbs)
    if isinstance(progress, Clarification):
        return progress
    reader = _Reader(text, verbs, names, times, aims)
    asked = reader.read(progress.clauses)
    return asked or reader.understood()


@dataclass
class _Reader:
    """Reads the clauses of one sentence."""

    text: str
    verbs: Verbs
    names: References
    times: Times
    aims: Aims
    goals: list[SymbolicFact] = field(default_factory=list)
    constraints: Constraints = UNCONSTRAINED
    due: Due | None = None
    readings: list[Reading] = field(default_factory=list)
    holds: list[StatedHold] = field(default_factory=list)

    def understood(self) -> Understood:
        said = self.names.roles
        goals, stages = with_roles(self.goals, self.constraints.stages, said)
        robots, without = (
            _of_roles(names, said) for names in (self.constraints.robots, self.constraints.without)
        )
        preferences = tuple(
            preference.model_copy(
                update={
                    "robots": _of_roles(preference.robots, said),
                    "without": _of_roles(preference.without, said),
                }
            )
            for preference in self.constraints.preferences
        )
        stated = {"stages": stages, "robots": robots, "without": without, "preferences": preferences}
        return Understood(
            goals=goals,
            constraints=self.constraints.model_copy(update=stated),
            due=self.due,
            readings=tuple(self.readings),
            holds=tuple(self.holds),
        )

    def read(self, clauses: Sequence[Clause]) -> Clarification | None:
        """Read the clauses in order; what to ask if one is not understood."""
        commands = commands_of(clauses, self.verbs)
        if isinstance(commands, Clarification):
            return commands
        if not any(command.verb or command.says_end for command in commands):
            return self._nothing_said(commands)
        stages: list[int] = []
        for command in commands:
            asked = (
                self._keep(command) if command.is_keep else self._command(command) if command.verb else None
            )
            asked = asked or self._constrain(command)
            if asked is not None:
                return asked
            stages.extend([command.stage] * (len(self.goals) - len(stages)))
        if len(self.goals) > MAX_GOALS:
            detail = f"{len(self.goals)} goals are more than the {MAX_GOALS} that one sentence may state"
            return Clarification(code="too-many-goals", detail=detail)
        self._set_stages(stages)
        return None

    def _set_stages(self, stages: Sequence[int]) -> None:
        """Constrain the order of the goals if "then" stands between them."""
        if len(set(stages)) > 1:
            steps = [
                " and ".join(str(goal) for goal, one in zip(self.goals, stages, strict=True) if one == stage)
                for stage in sorted(set(stages))
            ]
            self.constraints = self.constraints.and_also(Constraints(stages=tuple(stages)))
            self.readings.append(Reading(said="then", means=tuple(steps)))

    def _nothing_said(self, commands: Sequence[Clause]) -> Clarification:
        """The question after a sentence without a command; first what its constraints lack."""
        for command in commands:
            asked = self._keep(command) if command.is_keep else None
            asked = asked or self._constrain(command)
            if asked is not None:
                return asked
        if kept := next((command for command in commands if command.is_keep), None):
            return Clarification(
                code="goal-not-understood",
                detail=f"until when is it to stay {'there' if kept.keeps_facts else 'empty'}? "
                "Or say what to move meanwhile",
                choices=("until", "for"),
                span=(kept.span[1], kept.span[1]),
            )
        return Clarification(
            code="goal-not-understood",
            detail='say what to move and where to, e.g. "move sample_1 to bay_7"',
            choices=self.names.samples,
        )

    def _command(self, clause: Clause) -> Clarification | None:
        """Add the goals of a command."""
        verb = self.verbs.by_word[clause.verb]
        _fill_object(clause, verb)
        arranged = self._arranged(clause, verb)
        if isinstance(arranged, Clarification):
            return arranged
        target, said_origin = arranged
        origin = None if said_origin is None or not said_origin.words else self.names.origin(said_origin)
        if isinstance(origin, Clarification):
            return origin
        partner = self._partner(clause, verb)
        subjects = self._subjects(clause, verb, target, origin, has_partner=partner is not None)
        if isinstance(subjects, Clarification):
            return subjects
        values: dict[str, Sequence[str]] = {_slot(verb, Role.OBJECT): subjects}
        if (name := verb.slot(Role.PARTNER)) is not None:
            others = self._others(clause, verb.slots[name].kind, subjects, partner)
            if isinstance(others, Clarification):
                return others
            values[name] = others
        return self._aim(clause, verb, values, target, origin)

    def _subjects(
        self, clause: Clause, verb: Verb, target: Phrase | None, origin: Origin | None, *, has_partner: bool
    ) -> Sequence[str] | Clarification:
        """What the command is about."""
        aim = None if target is None else self.names.place(target)
        self.names.settled = self.names.lying_in(aim) if isinstance(aim, str) else frozenset()
        phrases = clause.objects or [clause.object_or_gap()]
        subjects: list[str] = []
        for phrase in phrases[:1] if has_partner else phrases:
            found = self._named(verb.object_kind, phrase, clause.verb, origin)
            if isinstance(found, Clarification):
                return found
            subjects.extend(found)
        if verb.object_kind is Kind.PLACE:  # of a location with several berths, each
            world = self.names.world
            return [place for name in subjects for place in berths_of(name, world) or (name,)]
        return subjects

    def _others(
        self, clause: Clause, kind: Kind, subjects: Sequence[str], partner: Phrase | None
    ) -> Sequence[str] | Clarification:
        """The one that the subject is paired with."""
        end = clause.span[1]
        others = self._named(kind, partner or Phrase(span=(end, end)), clause.verb, None)
        if isinstance(others, Clarification):
            if partner is not None:
                return others
            rest = tuple(choice for choice in others.choices if choice not in subjects)
            return replace(others, choices=rest, link="with")
        if len(subjects) != 1 or len(others) != 1 or subjects[0] == others[0]:
            return self._not_two(clause, kind, [*subjects, *others], partner)
        return others

    def _not_two(
        self, clause: Clause, kind: Kind, found: Sequence[str], partner: Phrase | None
    ) -> Clarification:
        names = {Kind.SAMPLE: self.names.samples, Kind.ROBOT: self.names.robots}.get(
            kind, self.names.locations
        )
        return Clarification(
            code="goal-not-understood",
            detail=f"{clause.verb} takes two different ones, not {joined(found, last='and')}",
            thing=found[0],
            choices=tuple(name for name in names if name not in found),
            span=partner.span if partner else clause.span,
        )

    def _aim(
        self,
        clause: Clause,
        verb: Verb,
        values: dict[str, Sequence[str]],
        target: Phrase | None,
        origin: Origin | None,
    ) -> Clarification | None:
        """Add the goals, with the place that the command names, has by default, or that is free."""
        name = verb.slot(Role.TARGET)
        subjects = values[_slot(verb, Role.OBJECT)]
        asked = None
        if name is None:
            asked = self._add(verb, values)
        elif target is None or (not target.words and target.quantity is Quantity.NAMED):
            if verb.slots[name].default is None:
                return self._where_to(clause, verb.slots[name], verb.object_kind, subjects)
            asked = self._add(verb, values)
        elif (kind := self._free_kind(target)) is not None:
            asked = self._add_to_free(verb, values, name, target, kind)
        else:
            place = self.names.place(target, self.names.locations if verb.object_kind is Kind.ROBOT else ())
            if isinstance(place, Clarification):
                return place
            asked = self._add(verb, {**values, name: (place,)})
        return asked or self._elsewhere(clause, verb, subjects, origin)

    def _free_kind(self, target: Phrase) -> str | None:
        """The kind of place if the target is "any bay" or "free bays", not a name."""
        if target.quantity in (Quantity.ANY, Quantity.COUNT) or target.words[:1] == ("free",):
            return self.names.kind_of_place(target)
        return None

    def _add_to_free(
        self, verb: Verb, values: dict[str, Sequence[str]], name: str, target: Phrase, kind: str
    ) -> Clarification | None:
        slot = _slot(verb, Role.OBJECT)
        chosen = []
        for subject in values[slot]:
            place = self.names.free_place(target, kind, subject, self._aimed_at(verb, subject))
            if isinstance(place, Clarification):
                return place
            chosen.append(place)
            asked = self._add(verb, {**values, slot: (subject,), name: (place,)})
            if asked is not None:
                return asked
        self._note(target, chosen)
        return None

    def _aimed_at(self, verb: Verb, thing: str) -> list[str]:
        """The locations that the sentence so far, and goals of this kind beside it, aim at for other things."""
        kinds = {template.name for template in verb.templates}
        beside = [fact for fact in self.aims() if fact.predicate in kinds]
        return locations_aimed_at([*self.goals, *beside], thing, self.names.world)

    def _add(self, verb: Verb, values: dict[str, Sequence[str]]) -> Clarification | None:
        """Add the goals for every combination of the slots' values."""
        for combination in product(*values.values()):
            bound = dict(zip(values, combination, strict=True))
            derivations = dict(verb.derived)
            for name, slot in verb.slots.items():
                if name not in bound and slot.default is not None:
                    derivations[name] = Call.parse(slot.default)
            for name, call in derivations.items():
                value = self._derived(verb, call, bound)
                if isinstance(value, Clarification):
                    return value
                bound[name] = value
            self.goals.extend(
                SymbolicFact(predicate=goal.name, args=goal.filled(bound)) for goal in verb.templates
            )
        return None

    def _derived(self, verb: Verb, call: Call, bound: Mapping[str, str]) -> str | Clarification:
        match Function(call.name):
            case Function.PLACE_OF:
                return self.names.lying_place(bound[call.variables[0]])
            case Function.PARKING_OF:
                robot = bound[call.variables[0]]
                return self.names.parking_of(robot, self._aimed_at(verb, robot))
            case Function.CHARGER_OF:
                robot = bound[call.variables[0]]
                return self.names.charger_of(robot, self._aimed_at(verb, robot))
            case Function.KNOWN:
                predicate, *first = call.filled(bound)
                return self.names.known(predicate, first)

    def _named(
        self, kind: Kind, phrase: Phrase, verb: str, origin: Origin | None
    ) -> tuple[str, ...] | Clarification:
        found = self.names.things(kind, phrase, verb, origin)
        if not isinstance(found, Clarification) and found != (phrase.said,):
            self._note(phrase, found, origin)
        return found

    def _note(self, phrase: Phrase, means: Sequence[str], origin: Origin | None = None) -> None:
        """Note what a quantity or a description was resolved to; not the other spelling of a name."""
        is_name = phrase.quantity is Quantity.NAMED and tuple(means) == (
            next((name for name in means if _letters(name) == _letters(phrase.said)), ""),
        )
        said = self.text[slice(*phrase.span)]
        if said and not is_name:
            where = f" of {origin.name}" if origin and not phrase.whole else ""
            self.readings.append(Reading(said=f"{said}{where}", means=tuple(means)))

    def _arranged(self, clause: Clause, verb: Verb) -> tuple[Phrase | None, Phrase | None] | Clarification:
        """The phrases of the target and of the origin. Of two targets the first is where the sample lies."""
        targets = clause.phrases(Part.TARGET)
        origins = clause.phrases(Part.ORIGIN)
        if verb.slot(Role.TARGET) is None:
            origins = [*origins, *targets]
            targets = []
        if len(targets) == 2 and not origins:
            origins = targets[:1]
            targets = targets[1:]
        if len(targets) > 1 or len(origins) > 1:
            said = self.text[slice(*clause.span)]
            return Clarification(
                code="goal-not-understood",
                detail=f"{said!r} names too many places; say one from and one to",
                span=clause.span,
            )
        return (targets[0] if targets else None), (origins[0] if origins else None)

    def _partner(self, clause: Clause, verb: Verb) -> Phrase | None:
        """The phrase of the partner: after "with", or the second of two objects."""
        if verb.slot(Role.PARTNER) is None:
            return None
        if len(clause.objects) > 1:
            return clause.objects[1]
        for index, tail in enumerate(clause.tails):
            if tail.part is Part.WITH and not tail.is_preferred:
                del clause.tails[index]
                return tail.phrase
        return None

    def _elsewhere(
        self, clause: Clause, verb: Verb, subjects: Sequence[str], origin: Origin | None
    ) -> Clarification | None:
        """The question if a sample is not where the sentence says that it lies."""
        if origin is None or verb.object_kind is not Kind.SAMPLE:
            return None
        return self.names.elsewhere(subjects, origin, clause.object_or_gap())

    def _where_to(self, clause: Clause, slot: Slot, kind: Kind, subjects: Sequence[str]) -> Clarification:
        """Ask for the place, the likely ones first: bays to store in, doors to bring samples to."""
        names = self.names
        if kind is Kind.SAMPLE:
            free = {names.world.location_of[place] for place in free_places(names.world, names.facts)}
        elif kind is Kind.ROBOT:
            free = set.intersection(*(set(names.reached_by(robot)) for robot in subjects))
        else:
            free = set(names.locations)
        choices = tuple(
            sorted(
                free, key=lambda name: (names.world.location(name).kind not in slot.likely, natural_key(name))
            )
        )
        thing = joined(subjects, last="and")
        said = clause.phrases(Part.TARGET)
        end = said[-1].span[1] if said else clause.span[1]
        return Clarification(
            code="place-needed",
            detail=f"{clause.verb} {thing} where to?",
            thing=subjects[0],
            choices=choices,
            span=(end, end),
            link="" if said else "to",
        )

    def _keep(self, clause: Clause) -> Clarification | None:
        """Constrain the places that are to be kept empty, or what is to be kept where it is."""
        phrases = clause.objects or [clause.object_or_gap()]
        if not clause.says_empty and (clause.keeps_facts or any(map(self.names.kind_of, phrases))):
            return self._keep_facts(clause)
        found: list[str] = []
        for phrase in phrases:
            named = self._named(Kind.PLACE, phrase, "keep", None)
            if isinstance(named, Clarification):
                return named
            found.extend(named)
        if not clause.says_empty:
            at = clause.objects[-1].span[1] if clause.objects else clause.object_at
            return Clarification(
                code="goal-not-understood",
                detail=f"keep {joined(found, last='and')} empty?",
                choices=("empty",),
                span=(at, at),
            )
        end = self._end_of(clause)
        if isinstance(end, Clarification):
            return end
        if clause.is_preferred:
            return self._prefer_empty(clause, found, end)
        if end is None:
            self.constraints = self.constraints.and_also(Constraints(keep_empty=_unique(found)))
        else:
            self.holds.append(StatedHold(places=_unique(found), until=end))
        return None

    def _keep_facts(self, clause: Clause) -> Clarification | None:
        """Constrain, or hold, where samples and robots are."""
        facts: list[HoldFact] = []
        for phrase in clause.objects or [clause.object_or_gap()]:
            kept = self._kept(clause, phrase)
            if isinstance(kept, Clarification):
                return kept
            facts.extend(kept)
        end = self._end_of(clause)
        if isinstance(end, Clarification):
            return end
        if clause.is_preferred:
            return Clarification(
                code="goal-not-understood",
                detail="only that a place is kept empty can be preferred; leave out that it is only preferred",
                thing=self.text[slice(*clause.first_span)],
                span=clause.first_span,
            )
        if end is None:
            self.constraints = self.constraints.and_also(Constraints(keep=tuple(facts)))
        else:
            self.holds.append(StatedHold(facts=tuple(dict.fromkeys(facts)), until=end))
        return None

    def _kept(self, clause: Clause, phrase: Phrase) -> Sequence[HoldFact] | Clarification:
        """The facts that what a phrase names is where the clause says."""
        kind = self.names.kind_of(phrase) or Kind.SAMPLE
        things = self._named(kind, phrase, "keep", None)
        if isinstance(things, Clarification):
            return things
        targets = clause.phrases(Part.TARGET)
        if len(targets) > 1 or clause.phrases(Part.ORIGIN):
            said = self.text[slice(*clause.span)]
            detail = f"{said!r} names too many places; say one"
            return Clarification(code="goal-not-understood", detail=detail, span=clause.span)
        choices = self.names.locations if kind is Kind.ROBOT else self.names.holding()
        if not targets or not targets[0].words:
            end = targets[0].span[1] if targets else phrase.span[1]
            detail = f"keep {joined(things, last='and')} where?"
            link = "" if targets else "at" if kind is Kind.ROBOT else "in"
            return Clarification(
                code="place-needed",
                detail=detail,
                thing=things[0],
                choices=choices,
                span=(end, end),
                link=link,
            )
        place = self.names.place(targets[0], choices)
        if isinstance(place, Clarification):
            return place
        predicate = NEAR if kind is Kind.ROBOT else IN
        return [HoldFact(predicate=predicate, args=(thing, place)) for thing in things]

    def _end_of(self, clause: Clause) -> HoldEnd | Clarification | None:
        """Until when a clause wants something kept; None if it does not say it."""
        ends = [tail for tail in clause.tails if tail.part in ENDS]
        if not ends:
            return None
        if len(ends) > 1:
            said = self.text[slice(*ends[1].span)]
            detail = f"{said!r} is a second end; say one"
            return Clarification(code="two-ends", detail=detail, thing=said, span=ends[1].span)
        found = hold_end(ends[0], self.text, self.names, self.times)
        if isinstance(found, Clarification):
            return found
        self.readings.append(Reading(said=self.text[slice(*ends[0].span)], means=(found[1],)))
        return found[0]

    def _prefer_empty(
        self, clause: Clause, places: Sequence[str], end: HoldEnd | None
    ) -> Clarification | None:
        """Prefer that these places are kept empty."""
        if end is not None:
            return Clarification(
                code="goal-not-understood",
                detail="a hold, with an end, is kept or not made; leave out its end, or that it is only preferred",
                span=next(tail.span for tail in clause.tails if tail.part in ENDS),
            )
        cost = clause.tails.pop(0) if clause.tails and clause.tails[0].part is Part.COST else None
        return self._prefer(Constraints(keep_empty=_unique(places)), cost)

    def _prefer(self, constraint: Constraints, cost: Tail | None) -> Clarification | None:
        """Add a preference."""
        cost_s = DEFAULT_COST_S if cost is None else cost.seconds
        if cost is not None and not 0 < cost_s <= MAX_WORTH:
            return Clarification(
                code="cost-needed",
                detail=f"what is the preference worth? A number of seconds, above 0 and at most {MAX_WORTH:g}",
                thing=self.text[slice(*cost.span)],
                choices=(f"cost {DEFAULT_COST_S:g}",),
                span=cost.span,
            )
        if constraint:
            preference = StatedPreference(cost_s=cost_s, **constraint.model_dump(exclude_defaults=True))
            self.constraints = self.constraints.and_also(Constraints(preferences=(preference,)))
        return None

    def _constrain(self, clause: Clause) -> Clarification | None:
        """Add the constraints and the preferences of a clause."""
        required = [tail for tail in clause.tails if not tail.is_preferred and tail.part is not Part.COST]
        stated = self._stated(required)
        if isinstance(stated, Clarification):
            return stated
        self.constraints = self.constraints.and_also(stated)
        preference: list[Tail] = []
        for tail in clause.tails:
            if tail.part is Part.COST and not preference:
                said = self.text[slice(*tail.span)]
                return Clarification(
                    code="goal-not-understood",
                    detail=f"{said!r} says of no preference what it costs to break it; say first what you would prefer",
                    thing=said,
                    choices=("preferably",),
                    span=tail.span,
                )
            is_end = tail.part is Part.COST or not tail.is_more
            if preference and is_end:
                asked = self._preference_of(preference, tail if tail.part is Part.COST else None)
                if asked is not None:
                    return asked
                preference = []
            if tail.is_preferred:
                preference.append(tail)
        asked = self._preference_of(preference, None) if preference else None
        return asked or self._terms(clause)

    def _preference_of(self, tails: Sequence[Tail], cost: Tail | None) -> Clarification | None:
        stated = self._stated(tails)
        return stated if isinstance(stated, Clarification) else self._prefer(stated, cost)

    def _terms(self, clause: Clause) -> Clarification | None:
        """Set what a clause says of time."""
        said: list[str] = []
        for tail in clause.tails:
            if tail.part is Part.AFTER:
                mission = self.times.mission(tail.phrase, self.text)
                if isinstance(mission, Clarification):
                    return mission
                said.append(mission)
            elif tail.part in ENDS and not clause.is_keep:
                return Clarification(
                    code="goal-not-understood",
                    detail=f"{self.text[slice(*tail.span)]!r} says nothing to keep as it is",
                    thing=self.text[slice(*tail.span)],
                    span=tail.span,
                )
            elif tail.part in (Part.DUE, Part.WITHIN):
                asked = self._set_due(tail)
                if asked is not None:
                    return asked
        self.constraints = self.constraints.and_also(Constraints(after=_unique(said)))
        return None

    def _stated(self, tails: Sequence[Tail]) -> Constraints | Clarification:
        """The constraints on robots and places that these tails state together."""
        said: dict[Part, list[str]] = {}
        for tail in tails:
            if tail.part in (Part.WITH, Part.WITHOUT, Part.AVOIDING, Part.THROUGH):
                found = self._listed(tail)
                if isinstance(found, Clarification):
                    return found
                said.setdefault(tail.part, []).extend(found)
        others = self._other_ways(tails, said.get(Part.THROUGH, ()))
        if isinstance(others, Clarification):
            return others
        return Constraints(
            robots=_unique(said.get(Part.WITH, ())),
            without=_unique(said.get(Part.WITHOUT, ())),
            avoid=_unique((*said.get(Part.AVOIDING, ()), *others)),
        )

    def _other_ways(self, tails: Sequence[Tail], through: Sequence[str]) -> Sequence[str] | Clarification:
        """The interchanges to avoid so that samples go through these."""
        if not through:
            return ()
        ways = interchanges(self.names.world)
        wrong = next((name for name in through if name not in ways), None)
        phrase = next(tail.phrase for tail in tails if tail.part is Part.THROUGH)
        if wrong is not None:
            return Clarification(
                code="no-interchange",
                detail=f"{wrong} is no interchange; samples go through {joined(ways, last='and') or 'none here'}",
                thing=wrong,
                choices=ways,
                span=phrase.span,
            )
        others = [name for name in ways if name not in through]
        if not others:
            return ()
        said = f"through {joined(through, last='and')}"
        self.readings.append(Reading(said=said, means=(f"avoiding {joined(others, last='and')}",)))
        return others

    def _listed(self, tail: Tail) -> tuple[str, ...] | Clarification:
        kind = Kind.ROBOT if tail.part in (Part.WITH, Part.WITHOUT) else Kind.PLACE
        verb = {Part.WITH: "with", Part.WITHOUT: "without", Part.THROUGH: "through"}.get(
            tail.part, "avoiding"
        )
        phrase = tail.phrase
        if phrase.quantity is Quantity.ANY:  # "without any robot of the yard" is without all of them
            phrase = replace(phrase, quantity=Quantity.ALL)
        found = self._named(kind, phrase, verb, None)
        if isinstance(found, Clarification) and not tail.phrase.words:
            return replace(found, span=(tail.span[1], tail.span[1]))
        return found

    def _set_due(self, tail: Tail) -> Clarification | None:
        said = self.text[slice(*tail.span)]
        if self.due is not None:
            detail = f"{said!r} is a second deadline; say one"
            return Clarification(code="two-deadlines", detail=detail, thing=said, span=tail.span)
        found = self.times.due(tail, self.text)
        if isinstance(found, Clarification):
            return found
        self.due, shown = found
        self.readings.append(Reading(said=said, means=(shown,)))
        return None


def _fill_object(clause: Clause, verb: Verb) -> None:
    """The object that is not said after the verb: "drill at site_3", "have rover_2 wait at base".

    A robot that is to do it and is not the object counts as said after "with".
    """
    agent = clause.agent
    if agent is not None and verb.object_kind is Kind.ROBOT and not clause.objects:
        clause.objects.append(agent)
    elif agent is not None:
        clause.tails.append(Tail(part=Part.WITH, phrase=agent, span=agent.span))
    if verb.object_kind is Kind.PLACE and verb.slot(Role.TARGET) is None and not clause.objects:
        index = next((n for n, tail in enumerate(clause.tails) if tail.part is Part.TARGET), None)
        if index is not None:
            clause.objects.append(clause.tails.pop(index).phrase)


def _slot(verb: Verb, role: Role) -> str:
    return next(name for name, slot in verb.slots.items() if slot.role is role)


def _of_roles(names: Sequence[str], said: Players) -> tuple[str, ...]:
    """The names with each role that was said in place of all robots that play it."""
    for role, robots in said.items():
        if set(robots) <= set(names):
            names = (role, *(name for name in names if name not in robots))
    return tuple(names)


def _unique(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _letters(name: str) -> str:
    return name.replace("_", "")
