"""Goals that can never be true together: proven by what the knowledge base lets hold only one at a time."""

from collections.abc import Iterator
from itertools import combinations

from planner.engine import PlanningProblem
from planner.fact import Fact
from planner.knowledge import KnowledgeBase


def contradicting_goals(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> tuple[tuple[Fact, Fact], ...]:
    """The pairs of goals of which at most one can be true at a time; with one of them, there is no plan.

    Two samples in a place with room for one, or a robot in two places: values of one variable (`planner.bounds.
    invariants`) that has one value among the present facts. Not all contradictions are found.
    """
    goals = list(dict.fromkeys(problem.goals))
    return tuple(pair for pair in combinations(goals, 2) if any(_shared(*pair, knowledge_base, problem)))


def _shared(
    one: Fact, other: Fact, knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> Iterator[bool]:
    """For each variable of an object that both facts name: whether both would be its value."""
    from planner.bounds.invariants import (
        variables_of,
    )  # NOTE: only a planning process has use for what it brings

    for name in sorted(set(one.args) & set(other.args) & problem.objects.keys()):
        for variable in variables_of(knowledge_base, frozenset({problem.objects[name]})):
            yield (
                variable.has(one.predicate, one.args, name)
                and variable.has(other.predicate, other.args, name)
                and variable.is_single(problem.facts, name)
            )
