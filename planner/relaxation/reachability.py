"""Which goals of a planning problem the delete relaxation reaches."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem
from planner.problem.static_facts import StaticFacts
from planner.relaxation.network import Closure, Derivations, Network
from planner.relaxation.rules import (
    BETWEEN,
    FROM,
    FUNCTION,
    GOAL,
    TO,
    TYPE,
    argument_types,
    is_between_alike,
    positions_needed,
    rules_of,
)

NETWORKS = 64
"""Compiled networks that are kept, the most recently used."""


class Relaxation:
    """What a problem's facts reach, together with others that are only supposed.

    :param supposed: further facts; missing values of functions as facts of the predicate `function:name`.
    :param observed: predicates whose facts are asked for with all their arguments.
    :param with_functions: False: durations are taken as defined everywhere.
    """

    def __init__(
        self,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        *,
        supposed: Iterable[Fact] = (),
        observed: Collection[str] = (),
        with_functions: bool = True,
    ) -> None:
        network = _network_of(knowledge_base, problem, observed=observed, with_functions=with_functions)
        self._derivations = Derivations(network)
        for fact in _given(problem, members_of(knowledge_base, problem.objects)):
            self._derivations.give(fact)
        for fact in supposed:
            self._derivations.give(fact, supposed=True)

    def run(self, until: Iterable[Fact] = ()) -> None:
        """Derive everything, or stop as soon as these goals are reached."""
        self._derivations.run(map(on_purpose, until))

    def missing(self, goal: Fact) -> frozenset[Fact] | None:
        """The fewest supposed facts that the goal rests on; None: out of reach even with them."""
        return self._derivations.supposed(on_purpose(goal))

    def leaves(self, goal: Fact) -> frozenset[Fact]:
        """All the facts that the way to the goal starts from."""
        return self._derivations.leaves(on_purpose(goal))

    def holds(self, fact: Fact) -> bool:
        """True if the fact of an observed predicate is reached, by intended or other effects."""
        return self._derivations.supposed(fact) is not None


def is_relaxed_reachable(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> bool:
    """False proves that the problem has no plan."""
    return not unreachable_goals(knowledge_base, problem)


def unreachable_goals(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> tuple[Fact, ...]:
    """The goals that could not be brought about even if nothing were ever deleted; none of them has a plan.

    Things that no goal names count as one (`with_bystanders_merged`), so that a store full of them takes no longer.
    """
    problem = with_bystanders_merged(knowledge_base, problem)
    network = _network_of(knowledge_base, problem, by_class=True)
    given = (
        *_stated(problem, members_of(knowledge_base, problem.objects)),
        *_values_by_class(knowledge_base, problem),
    )
    goals = {goal: on_purpose(goal) for goal in problem.goals}
    closure = Closure(network, given, goals.values())
    return tuple(goal for goal, meant in goals.items() if not closure.holds(meant))


def with_bystanders_merged(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> PlanningProblem:
    """The problem in which one thing stands for all of its type that no goal names and static facts say the same of.

    What the relaxation reaches in the problem it reaches in this one, with the thing in place of those that it stands
    for: the renaming maps every derivation to one. Hence goals that are out of reach here are so there. Things of which
    an action handles two stay apart, as these must differ.
    """
    statics = StaticFacts(knowledge_base, problem)
    named = {name for goal in problem.goals for name in goal.args}
    said: dict[str, set[str]] = {}
    for fact in statics.facts:
        if len(fact.args) == 1:
            said.setdefault(fact.args[0], set()).add(fact.predicate)
    bystanders = sorted(statics.things - named)
    apart = {kind for kind in {problem.objects[name] for name in bystanders} if _meet(knowledge_base, kind)}
    standing_for: dict[tuple[str, frozenset[str]], str] = {}
    renaming: dict[str, str] = {}
    for name in bystanders:
        kind = problem.objects[name]
        if kind not in apart:
            renaming[name] = standing_for.setdefault((kind, frozenset(said.get(name, ()))), name)
    gone = {name for name, other in renaming.items() if name != other}
    if not gone:
        return problem
    return replace(
        problem,
        objects={name: kind for name, kind in problem.objects.items() if name not in gone},
        facts=frozenset(
            fact if gone.isdisjoint(fact.args) else fact.renamed(renaming) for fact in problem.facts
        ),
    )


def _meet(knowledge_base: KnowledgeBase, kind: str) -> bool:
    """True if an action has parameters for two objects of the type."""
    is_a = knowledge_base.file.is_a
    return any(
        sum(is_a(kind, one) for one in operator.parameters.values()) > 1
        for operator in knowledge_base.operators
    )


def on_purpose(goal: Fact) -> Fact:
    """The fact that the goal held from the start or was an intended effect (MACTA §5, table 3)."""
    return Fact(GOAL + goal.predicate, goal.args)


def _network_of(
    knowledge_base: KnowledgeBase,
    problem: PlanningProblem,
    *,
    observed: Collection[str] = (),
    with_functions: bool = True,
    by_class: bool = False,
) -> Network:
    return _network(
        knowledge_base,
        frozenset(problem.objects.items()),
        frozenset(goal.predicate for goal in problem.goals),
        frozenset(observed),
        knowledge_base.phased_for(problem.facts),
        with_functions=with_functions,
        by_class=by_class,
        is_chained=any(fact.predicate in knowledge_base.under_way for fact in problem.facts),
    )


@lru_cache(maxsize=NETWORKS)
def _network(
    knowledge_base: KnowledgeBase,
    objects: frozenset[tuple[str, str]],
    goal_predicates: frozenset[str],
    observed: frozenset[str],
    phased: frozenset[str],
    *,
    with_functions: bool,
    by_class: bool,
    is_chained: bool,
) -> Network:
    """The rules compiled for these objects: whatever their facts, problems of a world share it."""
    rules = rules_of(
        knowledge_base,
        goal_predicates,
        phased,
        with_functions=with_functions,
        by_class=by_class,
        is_chained=is_chained,
    )
    whole = {*observed, *(GOAL + predicate for predicate in goal_predicates)}
    kept = positions_needed(rules, knowledge_base, whole)
    return Network(
        rules,
        members=members_of(knowledge_base, dict(objects)),
        types={name: argument_types(name, knowledge_base) for name in kept},
        kept=kept,
    )


def members_of(knowledge_base: KnowledgeBase, objects: Mapping[str, str]) -> dict[str, frozenset[str]]:
    """For each type its objects and constants, those of its subtypes among them."""
    members: dict[str, set[str]] = defaultdict(set)
    for name, kind in (*knowledge_base.constants.items(), *objects.items()):
        step: str | None = kind
        while step is not None:
            members[step].add(name)
            step = knowledge_base.file.types[step].parent
    return {kind: frozenset(names) for kind, names in members.items()}


def _given(problem: PlanningProblem, members: Mapping[str, frozenset[str]]) -> Iterator[Fact]:
    """All that holds from the start."""
    yield from _stated(problem, members)
    for name, args in problem.functions:
        yield Fact(FUNCTION + name, args)


def _stated(problem: PlanningProblem, members: Mapping[str, frozenset[str]]) -> Iterator[Fact]:
    """What holds from the start, but for what functions have values for."""
    goals = set(problem.goals)
    for fact in problem.facts:
        yield fact
        if fact in goals:
            yield on_purpose(fact)
    for kind, names in members.items():
        for name in names:
            yield Fact(TYPE + kind, (name,))


def _values_by_class(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> Iterator[Fact]:
    """What functions have values for; of two objects of a type by classes of objects with the same others.

    Each has one with itself as well, else no two had the same others. Rules tell apart what an action must not have
    twice; for one that may, more is within reach, so that what is out of reach is so.
    """
    others: dict[str, tuple[dict[str, set[str]], dict[str, set[str]]]] = {}
    for name, args in problem.functions:
        if not is_between_alike(name, knowledge_base):
            yield Fact(FUNCTION + name, args)
            continue
        ahead, behind = others.setdefault(name, ({}, {}))
        first, second = args
        ahead.setdefault(first, {first}).add(second)
        behind.setdefault(second, {second}).add(first)
    for name, (ahead, behind) in others.items():
        classes_from = _classes(ahead)
        classes_to = _classes(behind)
        for one, number in classes_from.items():
            yield Fact(FROM + name, (one, number))
        for one, number in classes_to.items():
            yield Fact(TO + name, (one, number))
        first_of = {number: one for one, number in classes_from.items()}
        for number, one in first_of.items():
            for other in {classes_to[two] for two in ahead[one] if two in classes_to}:
                yield Fact(BETWEEN + name, (number, other))


def _classes(others: Mapping[str, set[str]]) -> dict[str, str]:
    """The number of the class of each object: of those with the same others."""
    numbers: dict[frozenset[str], str] = {}
    return {one: numbers.setdefault(frozenset(with_it), str(len(numbers))) for one, with_it in others.items()}
