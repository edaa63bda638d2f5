"""Which goals of a planning problem the delete relaxation reaches."""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem
from planner.relaxation.network import Network
from planner.relaxation.rules import FUNCTION, GOAL, TYPE, argument_types, positions_needed, rules_of


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
        self._problem = problem
        goal_predicates = {goal.predicate for goal in problem.goals}
        under_way = any(fact.predicate in knowledge_base.under_way for fact in problem.facts)
        rules = rules_of(knowledge_base, goal_predicates, with_functions=with_functions, is_chained=under_way)
        whole = {*observed, *(GOAL + predicate for predicate in goal_predicates)}
        kept = positions_needed(rules, knowledge_base, whole)
        members = members_of(knowledge_base, problem.objects)
        self._network = Network(
            rules,
            members=members,
            types={name: argument_types(name, knowledge_base) for name in kept},
            kept=kept,
        )
        for fact in _given(problem, members):
            self._network.give(fact)
        for fact in supposed:
            self._network.give(fact, supposed=True)

    def run(self, until: Iterable[Fact] = ()) -> None:
        """Derive everything, or stop as soon as these goals are reached."""
        self._network.run(map(on_purpose, until))

    def missing(self, goal: Fact) -> frozenset[Fact] | None:
        """The fewest supposed facts that the goal rests on; None: out of reach even with them."""
        return self._network.supposed(on_purpose(goal))

    def leaves(self, goal: Fact) -> frozenset[Fact]:
        """All the facts that the way to the goal starts from."""
        return self._network.leaves(on_purpose(goal))

    def holds(self, fact: Fact) -> bool:
        """True if the fact of an observed predicate is reached, by intended or other effects."""
        return self._network.supposed(fact) is not None


def is_relaxed_reachable(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> bool:
    """False proves that the problem has no plan."""
    return not unreachable_goals(knowledge_base, problem)


def unreachable_goals(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> tuple[Fact, ...]:
    """The goals that could not be brought about even if nothing were ever deleted; none of them has a plan."""
    relaxation = Relaxation(knowledge_base, problem)
    relaxation.run(until=problem.goals)
    return tuple(goal for goal in dict.fromkeys(problem.goals) if relaxation.missing(goal) is None)


def on_purpose(goal: Fact) -> Fact:
    """The fact that the goal held from the start or was an intended effect (MACTA §5, table 3)."""
    return Fact(GOAL + goal.predicate, goal.args)


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
    goals = set(problem.goals)
    for fact in problem.facts:
        yield fact
        if fact in goals:
            yield on_purpose(fact)
    for name, args in problem.functions:
        yield Fact(FUNCTION + name, args)
    for kind, names in members.items():
        for name in names:
            yield Fact(TYPE + kind, (name,))
