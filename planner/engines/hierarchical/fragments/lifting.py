"""Lifted fragments: what was found for one goal with its objects left open, so that it fits others."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from planner.engines.hierarchical.fragments.relevance import goal_neighbourhood
from planner.engines.hierarchical.fragments.steps import Step
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.knowledge import Operator
from planner.plan_nets.causality import FROM_START, causal_links


def signature(index: WorldIndex, goals: Sequence[Fact]) -> Hashable:
    """The goals' predicates, what the present facts say of their objects and of those next to them, which sorts
    of agents relate to which of these, and how far apart they are; free of names, so it holds across worlds."""
    core = list(goal_neighbourhood(index, goals, 1))
    numbers = {name: number for number, name in enumerate(core)}

    def word(arg: str) -> str | int:
        if arg in numbers:
            return numbers[arg]
        if arg in index.agents:
            return " ".join(index.profiles[index.kind_of[arg]])
        return index.type_word(arg)

    aims = tuple((goal.predicate, *map(word, goal.args)) for goal in goals)
    facts = frozenset(
        (fact.predicate, *map(word, fact.args)) for name in core for fact in index.fluent_facts(name)
    )
    related: dict[int, list[int]] = {}
    for number, name in enumerate(core):
        for node in index.neighbours(index.node(name)):
            if isinstance(node, int):
                related.setdefault(node, []).append(number)
    kinds = frozenset((index.profiles[kind], tuple(places)) for kind, places in related.items())
    named = [(numbers[name], index.node(name)) for name in core if index.neighbours(index.node(name))]
    steps = tuple(
        (one, other, index.distance(node, far)) for (one, node), (other, far) in combinations(named, 2)
    )
    types = tuple(index.objects[name] for name in core)
    return aims, types, facts, kinds, steps


Term = int | str
"""A variable by its number, or a constant."""


@dataclass(frozen=True, slots=True)
class Pattern:
    """A literal over a fragment's variables."""

    predicate: str
    terms: tuple[Term, ...]

    def row(self, values: Sequence[str | None]) -> tuple[str, ...]:
        """The arguments where all its variables are bound."""
        return tuple([term if term.__class__ is str else values[term] or "" for term in self.terms])  # type: ignore[index]


@dataclass(frozen=True, slots=True)
class LiftedStep:
    """An operator with a variable for each of its parameters."""

    name: str
    variables: tuple[int, ...]
    op: Operator = field(compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class LiftedFragment:
    """Operators over variables that bind to different objects.

    :ivar conditions: static facts, and what it takes from the present facts.
    :ivar effects: for each step what others or the goals take from it and nothing in it removed before; if all
        of it holds at present, the step is redundant.
    :ivar kinds: each variable's types; its value must be of all of them.
    :ivar agents: the variables that stand for agents and are none of the goals' arguments.
    """

    goals: tuple[Pattern, ...]
    steps: tuple[LiftedStep, ...]
    conditions: tuple[Pattern, ...]
    effects: tuple[tuple[Pattern, ...], ...]
    kinds: tuple[frozenset[str], ...]
    agents: frozenset[int]
    order: tuple[int, ...] = field(compare=False)
    """The variables beside the goals' in an order that leaves few choices each time."""


def lift(index: WorldIndex, goals: Sequence[Fact], steps: Sequence[Step]) -> LiftedFragment:
    """The fragment of a solution, each object a variable."""
    numbers: dict[str, int] = {}

    def pattern(fact: Fact) -> Pattern:
        return Pattern(
            fact.predicate,
            tuple(
                numbers.setdefault(arg, len(numbers)) if arg in index.objects else arg for arg in fact.args
            ),
        )

    aims = tuple(map(pattern, goals))
    fixed = len(numbers)
    lifted = tuple(
        LiftedStep(step.op.name, tuple(numbers.setdefault(arg, len(numbers)) for arg in step.args), step.op)
        for step in steps
    )
    initial, effects = _needs_and_effects(index, goals, steps)
    conditions = tuple(dict.fromkeys(map(pattern, initial)))
    kinds: list[set[str]] = [set() for _ in numbers]
    agents: set[int] = set()
    for step in lifted:
        for name, variable in zip(step.op.parameters, step.variables, strict=True):
            kinds[variable].add(step.op.parameters[name])
            if name in step.op.agents and variable >= fixed:
                agents.add(variable)
    return LiftedFragment(
        goals=aims,
        steps=lifted,
        conditions=conditions,
        effects=tuple(tuple(map(pattern, facts)) for facts in effects),
        kinds=tuple(map(frozenset, kinds)),
        agents=frozenset(agents),
        order=_order(index, conditions, list(numbers), fixed),
    )


def _needs_and_effects(
    index: WorldIndex, goals: Sequence[Fact], steps: Sequence[Step]
) -> tuple[list[Fact], list[list[Fact]]]:
    """What the steps take from the present facts, and what is taken from each step."""
    functions = index.problem.functions
    bound = ((step.op, dict(zip(step.op.parameters, step.args, strict=True))) for step in steps)
    actions = [action for op, binding in bound if (action := op.ground(binding, functions)) is not None]
    needs: list[Fact] = []
    used: list[dict[Fact, None]] = [{} for _ in actions]
    for link in causal_links(actions, index.problem.facts, goals):
        if link.producer == FROM_START:
            needs.append(link.fact)
        else:
            used[link.producer][link.fact] = None
    gone: set[Fact] = set()
    effects = []
    for action, facts in zip(actions, used, strict=True):
        gone.update(action.deletes)
        effects.append([] if gone & facts.keys() else list(facts))
    return needs, effects


def _order(
    index: WorldIndex, conditions: Sequence[Pattern], names: Sequence[str], fixed: int
) -> tuple[int, ...]:
    """The variables from `fixed` on, each next one with the fewest choices given those before."""
    order: list[int] = []
    open_ones = set(range(fixed, len(names)))
    while open_ones:

        def choices(variable: int) -> int:
            counts = [
                len(index.values(pattern.predicate, pattern.row(names), pattern.terms.index(variable)))
                for pattern in conditions
                if variable in pattern.terms and open_ones.isdisjoint(set(pattern.terms) - {variable})
            ]
            return min(counts, default=len(names) + len(index.objects))

        order.append(min(sorted(open_ones), key=choices))
        open_ones.remove(order[-1])
    return tuple(order)
