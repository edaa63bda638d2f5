"""Zones for one agent at a time that stay closed: they are not clear, and no agent inside can leave them.

The rules of the relaxation do not state what zones ask for (`planner.problem.zones`). Without the ways into closed
zones, what it does not reach no plan does either.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from itertools import product

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem
from planner.problem.zones import holders
from planner.relaxation.reachability import Relaxation


def closed_zones(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> Mapping[str, tuple[str, ...]]:
    """The closed zones, with the agents inside as far as they are known."""
    closed = dict(holders(problem, knowledge_base))
    while closed:
        open_problem = without_ways_into(problem, closed)
        relaxation = Relaxation(knowledge_base, open_problem, observed=set(knowledge_base.held.values()))
        relaxation.run()
        left = [
            zone
            for zone in closed
            if any(relaxation.holds(fact) for fact in _outside(zone, problem, knowledge_base))
        ]
        if not left:
            break
        closed = {zone: agents for zone, agents in closed.items() if zone not in left}
    return closed


def without_ways_into(problem: PlanningProblem, zones: Collection[str]) -> PlanningProblem:
    """The problem without what its functions say of ways that enter one of the zones."""
    entering = {
        way
        for way, crossed in problem.crossings.items()
        if any(one.enters and one.zone in zones for one in crossed)
    }
    functions = {call: value for call, value in problem.functions.items() if call[1] not in entering}
    return replace(problem, functions=functions)


def _outside(zone: str, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> Iterator[Fact]:
    """The positions outside that agents inside the zone may leave it for."""
    for position in knowledge_base.held.values():
        _, *between, _ = knowledge_base.predicates[position].arguments.values()
        values = list(product(*(knowledge_base.file.constants(kind) for kind in between)))
        for fact in problem.facts:
            if fact.predicate != position:
                continue
            for (start, end), crossed in problem.crossings.items():
                if start == fact.args[-1] and any(one.zone == zone and one.leaves for one in crossed):
                    yield from (Fact(position, (fact.args[0], *some, end)) for some in values)
