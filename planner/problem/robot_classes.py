"""Classes of interchangeable robots: same abilities, senses, reach and speed, recruited for the same goals.

Objects of one agent alone do not distinguish it: an agent's *own* objects are those that static facts name with no
other agent, that no goal names, and that no present fact names except for where agents are and whether the way is clear
(a robot's home, for instance). An object that is the only one in a relation to its agent counts (its area).
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem

ANYONE = "?"
"""Placeholder for the agent in a fact about a whole class."""
OWN = "own"
"""Placeholder for an object of one agent alone, its charger for instance, in what functions say of it."""


class AgentClasses:
    """The agents of a problem by class: alike in every static fact and function that names them."""

    def __init__(self, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
        self.agents = knowledge_base.agents_among(problem.objects)
        self.own = _own_objects(self.agents, knowledge_base, problem)
        said = _said_of(self.agents, self.own, knowledge_base, problem)
        numbers: dict[tuple[str, frozenset[object]], int] = {}
        self._number = {
            agent: numbers.setdefault((problem.objects[agent], said[agent]), len(numbers))
            for agent in self.agents
        }
        self.members: Mapping[int, tuple[str, ...]] = {
            number: tuple(agent for agent in self.agents if self._number[agent] == number)
            for number in numbers.values()
        }

    def number(self, agent: str) -> int:
        """The agent's class."""
        return self._number[agent]


def _own_objects(
    agents: Iterable[str], knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> frozenset[str]:
    known = frozenset(agents)
    fluents = knowledge_base.fluents
    users: dict[str, set[str]] = defaultdict(set)
    busy = {arg for goal in problem.goals for arg in goal.args}
    for fact in problem.facts:
        named = known.intersection(fact.args)
        if fact.predicate not in fluents:
            for arg in fact.args:
                users[arg] |= named
        elif not named and not knowledge_base.predicates[fact.predicate].make_way:
            busy.update(fact.args)
    own = {name for name, those in users.items() if len(those) == 1 and name in problem.objects}
    own -= busy | known
    static = [fact for fact in problem.facts if fact.predicate not in fluents]
    kept = {
        (fact.predicate, agent)
        for fact in static
        if own.isdisjoint(fact.args)
        for agent in known.intersection(fact.args)
    }
    needed = {
        arg
        for fact in static
        for agent in known.intersection(fact.args)
        if (fact.predicate, agent) not in kept
        for arg in fact.args
    }
    return frozenset(own - needed)


def _said_of(
    agents: Iterable[str], own: frozenset[str], knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> Mapping[str, frozenset[object]]:
    """What the static facts and functions say of each agent, with its own name left open."""
    known = frozenset(agents)
    said: dict[str, set[object]] = defaultdict(set)
    fluents = knowledge_base.fluents
    for fact in problem.facts:
        if fact.predicate not in fluents and own.isdisjoint(fact.args):
            for agent in known.intersection(fact.args):
                said[agent].add(fact.renamed({agent: ANYONE}))
    for agent, words in problem.senses.items():
        if agent in known:
            said[agent].add(words)
    for goal, those in problem.recruits.items():
        for agent in known & those:
            said[agent].add(("recruited", goal))
    places = dict.fromkeys(own, OWN)
    for (name, args), value in problem.functions.items():
        for agent in known.intersection(args):
            said[agent].add((Fact(name, args).renamed({**places, agent: ANYONE}), value))
    return {agent: frozenset(said[agent]) for agent in known}
