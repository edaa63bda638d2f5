"""Zones for one agent at a time: what an action needs and changes that takes its agent into one, through or out of it.

The knowledge base names the predicate that says that a zone is clear, and that of the positions by which it is held
(`held_by`); the problem says which ways cross which zones. No action states any of it: `ground` adds to each ground
action what its agents' positions before and after ask for. So a zone is a fact like any other, and what follows from
it (causal links, orderings, clearances) needs no rule of its own.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product

from planner.errors import KnowledgeBaseError
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase, Operator
from planner.problem.access import with_access
from planner.problem.interface import Crossing, PlanningProblem


def ground(
    op: Operator, binding: Mapping[str, str], problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> GroundAction | None:
    """The action under a full binding, with what zones and doors ask for; None where its duration is not defined, or
    several agents would be in a zone at a time."""
    action = op.ground(binding, problem.functions)
    if action is None:
        return None
    return with_zones(with_access(action, problem, knowledge_base), problem, knowledge_base)


def groundings(
    op: Operator,
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
    told: Mapping[str, str] | None = None,
) -> Iterator[GroundAction]:
    """The ground actions of an operator.

    :param told: the objects that some of its parameters are bound to.
    """
    known = told or {}
    is_a = knowledge_base.file.is_a
    choices = [
        [known[name]]
        if name in known
        else [one for one, kind in sorted(problem.objects.items()) if is_a(kind, wanted)]
        for name, wanted in op.parameters.items()
    ]
    for values in product(*choices):
        binding = dict(zip(op.parameters, values, strict=True))
        if knowledge_base.misfit(op, binding, problem.objects) is None:
            action = ground(op, binding, problem, knowledge_base)
            if action is not None:
                yield action


def ground_again(
    action: GroundAction, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> GroundAction:
    """The action as the problem has it; one that is there for a number lasts as long as before.

    :raises KnowledgeBaseError: if it is no longer possible.
    """
    again = ground_action(action.tag, action.arguments, problem, knowledge_base, phase=action.phase)
    if action.level is None:
        return again
    return replace(again, duration_s=action.duration_s, level=action.level)


def ground_action(
    action: str,
    arguments: Mapping[str, str],
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
    *,
    phase: int = 0,
) -> GroundAction:
    """The action with these arguments, or a phase of it, with what zones and doors ask for.

    :raises KnowledgeBaseError: if the action, an argument or a duration is not known, or several agents would be in a
        zone at a time.
    """
    plain = knowledge_base.ground(action, arguments, problem.functions, objects=problem.objects)
    whole = with_zones(with_access(plain, problem, knowledge_base), problem, knowledge_base)
    if whole is None:
        raise KnowledgeBaseError(f"{plain}: {' and '.join(plain.agents)} would be in one zone at a time")
    if not phase:
        return whole
    found = knowledge_base.phase_of(whole, phase)
    if found is None:
        raise KnowledgeBaseError(f"{whole} has no phase {phase}")
    return found


def with_zones(
    action: GroundAction, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> GroundAction | None:
    """The action with what zones ask for; None if several of its agents would be in one at a time."""
    if not problem.crossings:
        return action
    for clear, position in knowledge_base.held.items():
        found = list(_crossed(action, position, problem))
        if not found:
            continue
        if len({agent for agent, _ in found}) > 1:
            return None
        entered = tuple(Fact(clear, (one.zone,)) for _, one in found if one.enters)
        left = tuple(Fact(clear, (one.zone,)) for _, one in found if one.leaves)
        action = replace(
            action,
            preconditions=(*action.preconditions, *entered),
            deletes=(*action.deletes, *entered),
            other_effects=(*action.other_effects, *left),
        )
    return action


def holders(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Each zone that is not clear, with the agents inside as far as they are known."""
    inside = {
        (start, one.zone)
        for (start, _), crossed in problem.crossings.items()
        for one in crossed
        if one.leaves and not one.enters
    }
    for clear, position in knowledge_base.held.items():
        for zone in sorted(problem.zones):
            if Fact(clear, (zone,)) not in problem.facts:
                there = (
                    fact.args[0]
                    for fact in problem.facts
                    if fact.predicate == position and (fact.args[-1], zone) in inside
                )
                yield zone, tuple(sorted(there))


def _crossed(action: GroundAction, position: str, problem: PlanningProblem) -> Iterator[tuple[str, Crossing]]:
    """The agents that move, and what zones they enter or leave by that."""
    before = _places(action.deletes, position)
    after = _places(action.effects, position)
    for agent in action.agents:
        if agent in before and agent in after:
            for crossing in problem.crossings.get((before[agent], after[agent]), ()):
                yield agent, crossing


def _places(facts: Iterable[Fact], position: str) -> dict[str, str]:
    return {fact.args[0]: fact.args[-1] for fact in facts if fact.predicate == position}
