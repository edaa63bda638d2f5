"""What every fragment must be."""

from collections.abc import Iterable

from planner import Fact, KnowledgeBase, PlanningProblem
from planner.engines.hierarchical.fragments.fragment import Fragment, Fragments
from planner.plan_nets.causality import causal_links
from planner.plan_nets.extraction import fault_of
from planner.plan_nets.redundancy import without_redundant


def fragments_of(
    fragments: Fragments, problem: PlanningProblem, goals: Iterable[Fact] | None = None
) -> tuple[Fragment, ...]:
    """The alternatives, each checked from outside."""
    wanted = tuple(goals if goals is not None else problem.goals)
    found = fragments.of(problem).alternatives(wanted)
    for fragment in found:
        assert faults(fragment, problem, fragments.knowledge_base) == []
    costs = [fragment.duration_s for fragment in found]
    assert costs == sorted(costs)
    assert len({frozenset(map(str, fragment.actions)) for fragment in found}) == len(found)
    return found


def faults(fragment: Fragment, problem: PlanningProblem, base: KnowledgeBase) -> list[str]:
    """Everything wrong with a fragment: invalid, redundant or unjustified actions."""
    fault = fault_of(fragment.actions, problem.facts, fragment.goals)
    if fault is not None:
        return [fault]
    found = []
    if len(without_redundant(fragment.actions, problem.facts, fragment.goals)) < len(fragment.actions):
        found.append("some action is redundant")
    links = causal_links(fragment.actions, problem.facts, fragment.goals)
    for number, action in enumerate(fragment.actions):
        used = [link.fact for link in links if link.producer == number]
        if not any(f in action.intended_effects or base.predicates[f.predicate].make_way for f in used):
            found.append(f"{action} is there only for {used}")
    return found


def tags(fragment: Fragment) -> list[str]:
    return [action.tag for action in fragment.actions]


def crew(fragment: Fragment) -> set[str]:
    return {agent for action in fragment.actions for agent in action.agents}
