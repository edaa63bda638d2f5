"""Operators: plan-net actions with their relations chosen and their lists of robots spelt out.

A plan-net action with `rel1 ∈ {at, near}` is two operators; one with teams of 1 or 2 robots, or with two variants,
likewise.
Parameters of one type are bound to different objects, unless the action says which are. Our choice for a team:
each literal with the list holds for every member, and the duration is the longest over the members.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations, product

from planner.fact import Fact
from planner.knowledge.action import (
    LITERAL_SLOTS,
    PRECONDITIONS,
    USUAL_SPANS,
    ActionSpec,
    VariantSpec,
    read_timed,
)
from planner.knowledge.change import DISTANCE, DURATION, ENERGY, NumberChange
from planner.knowledge.comparison import Comparison, Term, read_comparison
from planner.knowledge.expression import Expression, Functions, scale_term
from planner.knowledge.literal import Literal, ground_all
from planner.knowledge.schema import TIME
from planner.knowledge.timing import UNDER_WAY, Span

TEAM_SEPARATOR = "+"
"""Between the members of a team where an argument shows it: `fred+ginger`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundAction:
    """A plan-net action with all its arguments, not yet scheduled.

    `distance_m` and `energy_j`: what all its robots together drive and use. `under_way`: it runs already when the
    plan starts; duration, distance and energy are what is left of it. `phase`, `phases`: which of how many phases of
    the action it is (`planner.knowledge.phases`), counted from 1; 0: it is the whole action. `level`: of an action that
    is there for a number (`ActionSpec.until`), what this is to be at its end; None: of any other.
    """

    tag: str
    arguments: Mapping[str, str]
    agents: tuple[str, ...]
    preconditions: tuple[Fact, ...]
    deletes: tuple[Fact, ...]
    intended_effects: tuple[Fact, ...]
    other_effects: tuple[Fact, ...]
    duration_s: float
    distance_m: float = 0.0
    energy_j: float = 0.0
    under_way: bool = False
    phase: int = 0
    phases: int = 0
    level: float | None = None

    @property
    def is_kept(self) -> bool:
        """True if a plan keeps it whatever its effects are used for: it is under way, or there for a number."""
        return self.under_way or self.level is not None

    @property
    def own_terms(self) -> Functions:
        """Its duration, and its distance and energy of one robot, as changes of numbers name them."""
        team = max(len(self.agents), 1)
        return {
            DURATION: self.duration_s,
            DISTANCE: self.distance_m / team,
            ENERGY: self.energy_j / team,
        }

    @property
    def effects(self) -> tuple[Fact, ...]:
        return self.intended_effects + self.other_effects

    @property
    def follows(self) -> Fact | None:
        """Of a phase but the first: what shows that the one before it has ended."""
        return next(
            (fact for fact in self.deletes if self.phase and fact.predicate.startswith(UNDER_WAY)), None
        )

    def as_whole(self) -> str:
        """The action in words; of a phase, the whole action."""
        return f"{self.tag}({', '.join(self.arguments.values())})"

    def __str__(self) -> str:
        whole = self.as_whole()
        return f"{whole}, phase {self.phase} of {self.phases}" if self.phase else whole


@dataclass(frozen=True, kw_only=True)
class Operator:
    """One variant of a plan-net action: `parameters` maps the names left open to their types."""

    name: str
    spec: ActionSpec
    parameters: Mapping[str, str]
    chosen: Mapping[str, str]
    teams: Mapping[str, tuple[str, ...]]
    preconditions: tuple[Literal, ...]
    deletes: tuple[Literal, ...]
    intended_effects: tuple[Literal, ...]
    other_effects: tuple[Literal, ...]
    duration: Expression
    distance: Expression
    energy: Expression
    waiting: float
    """What one of its agents uses a second while it waits for it, beyond what it uses at rest."""
    spans: Mapping[str, Mapping[Literal, Span]] = field(default_factory=dict)
    """By slot, when literals concern the action that say so."""
    phases_when: tuple[Literal, ...] = ()
    """Static facts without which it has no phases."""
    changes: tuple[NumberChange, ...] = ()
    until: tuple[Comparison, tuple[str, ...]] | None = None
    """How far it changes the number that it is there for at most, and that number's terms, if it is there for one."""

    @cached_property
    def distinct(self) -> tuple[tuple[str, str], ...]:
        """The pairs of parameters that are bound to different objects."""
        pairs = combinations(self.parameters, 2)
        if self.spec.distinct is None:
            return tuple(pair for pair in pairs if self.parameters[pair[0]] == self.parameters[pair[1]])
        told = {frozenset(pair) for pair in self.spec.distinct}
        listed = {pair: frozenset(map(self._listed, pair)) for pair in pairs}
        return tuple(pair for pair, names in listed.items() if names in told or len(names) == 1)

    def _listed(self, parameter: str) -> str:
        """The parameter, or the list of robots that it is a member of."""
        return next((name for name, members in self.teams.items() if parameter in members), parameter)

    @cached_property
    def members(self) -> tuple[Mapping[str, str], ...]:
        """For every choice of one member a team: the list parameters' names → that member's."""
        return tuple(dict(zip(self.teams, choice, strict=True)) for choice in product(*self.teams.values()))

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        """The names of a ground action's arguments: of all parameters but times."""
        return tuple(parameter.name for parameter in self.spec.parameters if parameter.type != TIME)

    @cached_property
    def agents(self) -> tuple[str, ...]:
        return tuple(member for agent in self.spec.agents for member in self.teams.get(agent, (agent,)))

    def duration_s(self, binding: Mapping[str, str], functions: Functions) -> float | None:
        """Longest over the members, times the action's learned factor; None where a function has no value."""
        spans = []
        for alias in self._aliases(binding):
            seconds = self.duration.value(alias, functions)
            if seconds is None:
                return None
            spans.append(seconds)
        return max(spans) * functions.get(self._scale_term, 1.0)

    @cached_property
    def _scale_term(self) -> Term:
        return scale_term(self.spec.name, len(self.agents))

    def exertion(
        self, binding: Mapping[str, str], functions: Functions, duration_s: float
    ) -> tuple[float, float]:
        """Distance in metres and energy in joules, summed over the members; 0 where a function has no value."""
        distance_m = energy_j = 0.0
        for alias in self._aliases(binding):
            driven_m = self.distance.value(alias, functions) or 0.0
            known: Functions = {DURATION: duration_s, DISTANCE: driven_m}
            distance_m += driven_m
            energy_j += self.energy.value(alias, functions, known) or 0.0
        return round(distance_m, 3), round(energy_j, 3)

    def changed_numbers(
        self, binding: Mapping[str, str], functions: Functions, action: GroundAction
    ) -> dict[Term, float]:
        """By how much the action, or a phase of it, changes numbers; a team shares its distance and energy evenly."""
        known = action.own_terms
        changed: dict[Term, float] = {}
        for change in self.changes:
            told = {tuple(alias[term] for term in change.terms): alias for alias in self._aliases(binding)}
            for args, alias in told.items():
                key = change.quantity, args
                changed[key] = changed.get(key, 0.0) + change.value(alias, functions, known)
        return changed

    def _aliases(self, binding: Mapping[str, str]) -> Sequence[Mapping[str, str]]:
        """The binding with each list parameter bound to one member, for every choice."""
        if not self.teams:
            return (binding,)
        return [
            {**binding, **{name: binding[one] for name, one in member.items() if one in binding}}
            for member in self.members
        ]

    def extended(
        self, binding: Mapping[str, str], terms: Iterable[str], values: Iterable[str]
    ) -> dict[str, str] | None:
        """The binding with the terms bound to these values; None where that contradicts it or a constant."""
        extended = dict(binding)
        for term, value in zip(terms, values, strict=True):
            if term not in self.parameters:
                if term != value:
                    return None
            elif extended.setdefault(term, value) != value:
                return None
        return extended

    def ground(self, binding: Mapping[str, str], functions: Functions) -> GroundAction | None:
        """The action under a full binding of `parameters`; None where its duration is not defined."""
        seconds = self.duration_s(binding, functions)
        if seconds is None:
            return None
        distance_m, energy_j = self.exertion(binding, functions, seconds)
        return GroundAction(
            tag=self.spec.name,
            arguments={name: self._argument(name, binding) for name in self.arguments},
            agents=tuple([binding[agent] for agent in self.agents]),
            preconditions=ground_all(self.preconditions, binding),
            deletes=ground_all(self.deletes, binding),
            intended_effects=ground_all(self.intended_effects, binding),
            other_effects=ground_all(self.other_effects, binding),
            duration_s=round(seconds, 3),
            distance_m=distance_m,
            energy_j=energy_j,
        )

    def _argument(self, name: str, binding: Mapping[str, str]) -> str:
        if name in self.chosen:
            return self.chosen[name]
        if name in binding:
            return binding[name]
        return TEAM_SEPARATOR.join(binding[member] for member in self.teams.get(name, (name,)))


def operators_of(spec: ActionSpec) -> Iterator[Operator]:
    """All variants of a plan-net action."""
    narrowed = [parameter for parameter in spec.parameters if parameter.values]
    lists = [parameter for parameter in spec.parameters if parameter.teams]
    for variant in spec.variants:
        sizes_of = {p.name: (variant.teams[p.name],) if p.name in variant.teams else p.teams for p in lists}
        # The first variant is called as the action is.
        kinds = [] if variant is spec.variants[0] else list(variant.types.values())
        for values in product(*(parameter.values for parameter in narrowed)):
            for sizes in product(*sizes_of.values()):
                chosen = {parameter.name: value for parameter, value in zip(narrowed, values, strict=True)}
                teams = {name: _members(name, size) for name, size in zip(sizes_of, sizes, strict=True)}
                suffix = [chosen[parameter.name] for parameter in narrowed if len(parameter.values) > 1]
                suffix += [str(len(team)) for name, team in teams.items() if len(sizes_of[name]) > 1]
                name = "_".join([spec.name.lower(), *kinds, *map(str.lower, suffix)])
                yield _operator(spec, variant, name, chosen, teams)


def _members(parameter: str, size: int) -> tuple[str, ...]:
    return tuple(f"{parameter}_{number}" for number in range(1, size + 1))


def _operator(
    spec: ActionSpec,
    variant: VariantSpec,
    name: str,
    chosen: Mapping[str, str],
    teams: Mapping[str, tuple[str, ...]],
) -> Operator:
    parameters: dict[str, str] = {}
    for parameter in spec.parameters:
        if parameter.type != TIME and parameter.name not in chosen:
            kind = variant.types.get(parameter.name, parameter.type)
            parameters |= dict.fromkeys(teams.get(parameter.name, (parameter.name,)), kind)
    timed = {slot: _expand(spec.timed(slot, variant), chosen, teams) for slot in LITERAL_SLOTS}
    slots = {slot: tuple(literals) for slot, literals in timed.items()}
    return Operator(
        name=name,
        spec=spec,
        parameters=parameters,
        chosen=chosen,
        teams=teams,
        preconditions=slots["preconditions"],
        deletes=slots["delete"],
        intended_effects=slots["intended_effects"],
        other_effects=slots["other_effects"],
        duration=Expression.parse(spec.duration if variant.duration is None else variant.duration),
        distance=Expression.parse(spec.distance),
        energy=Expression.parse(spec.energy),
        waiting=spec.waiting if variant.waiting is None else variant.waiting,
        changes=tuple(map(NumberChange.parse, spec.changes)),
        until=read_comparison(spec.until) if spec.until else None,
        spans={slot: unusual for slot in timed if (unusual := _unusual(slot, timed[slot]))},
        phases_when=tuple(_expand(read_timed(PRECONDITIONS, spec.phases_when), chosen, teams)),
    )


def _unusual(slot: str, timed: Mapping[Literal, Span]) -> dict[Literal, Span]:
    """The literals of a slot that name their times."""
    return {literal: span for literal, span in timed.items() if span != USUAL_SPANS[slot]}


def _expand(
    timed: tuple[tuple[Literal, Span], ...], chosen: Mapping[str, str], teams: Mapping[str, tuple[str, ...]]
) -> dict[Literal, Span]:
    expanded: dict[Literal, Span] = {}
    for literal, span in timed:
        own = [name for name in teams if name in literal.terms]
        for members in product(*(teams[name] for name in own)):
            expanded[literal.rename({**chosen, **dict(zip(own, members, strict=True))})] = span
    return expanded
