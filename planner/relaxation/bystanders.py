"""Many things as one, where the delete relaxation only asks whether goals about other things are out of reach."""

from collections.abc import Iterator
from dataclasses import replace

from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem
from planner.problem.static_facts import StaticFacts


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
    supertypes = frozenset(_supertypes(knowledge_base, kind))
    return any(
        sum(one in supertypes for one in operator.parameters.values()) > 1
        for operator in knowledge_base.operators
    )


def _supertypes(knowledge_base: KnowledgeBase, kind: str) -> Iterator[str]:
    """The type and all that it is a subtype of."""
    step: str | None = kind
    while step is not None:
        yield step
        step = knowledge_base.file.types[step].parent
