"""The shape of goals: two of one shape are solved by the same lifted fragments, as a rule."""

from collections.abc import Hashable, Sequence
from itertools import combinations

from planner.engines.hierarchical.fragments.relevance import goal_neighbourhood
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact


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
