"""Doors, hatches and lifts: what an action asks of them that goes through, or puts or takes something there.

The knowledge base names the predicates that say what a peripheral is like, and the positions for whose change that
matters (`asked_by`); the problem says which ways and places ask for what. No action but the peripheral's own states any
of it: `with_access` adds it to the pre-conditions of ground actions, which hold from an action's start to its end. So
a door is open while anyone goes through, and what follows (causal links, orderings, clearances) needs no rule.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.problem.interface import PlanningProblem


def with_access(
    action: GroundAction, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> GroundAction:
    """The action with what its ways and places ask of doors, hatches and lifts, and what it needs to change one."""
    access = problem.access
    if not (access.ways or access.positions):
        return action
    asked = dict.fromkeys(_asked(action, problem, knowledge_base))
    ended = (fact for fact in action.deletes if fact in access.to_end)
    asked |= dict.fromkeys(needed for fact in ended for needed in access.to_end[fact])
    new = tuple(fact for fact in asked if fact not in action.preconditions)
    return replace(action, preconditions=(*action.preconditions, *new)) if new else action


def peripherals_of(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> frozenset[str]:
    """The doors, hatches and lifts: what has a state that others ask for."""
    kinds = {
        next(iter(knowledge_base.predicates[name].arguments.values())) for name in knowledge_base.accesses
    }
    is_a = knowledge_base.file.is_a
    return frozenset(
        name for name, kind in problem.objects.items() if any(is_a(kind, wanted) for wanted in kinds)
    )


def _asked(action: GroundAction, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> Iterator[Fact]:
    access = problem.access
    deletes, effects = knowledge_base.changes_of(action)
    for state, positions in knowledge_base.accesses.items():
        for position in positions:
            before = _positions(deletes, position)
            after = _positions(effects, position)
            for thing in dict.fromkeys((*before, *after)):
                start = before.get(thing, ())
                end = after.get(thing, ())
                asked = [*access.positions.get(start, ()), *access.positions.get(end, ())]
                if start and end:
                    asked += access.ways.get((start[-1], end[-1]), ())
                yield from (fact for fact in asked if fact.predicate == state)


def _positions(facts: Iterable[Fact], position: str) -> dict[str, tuple[str, ...]]:
    """Thing → the further arguments of its position."""
    return {fact.args[0]: fact.args[1:] for fact in facts if fact.predicate == position}
