"""Why a problem has no plan, in an operator's words, where it is cheap to tell."""

from collections.abc import Iterator

from planner.engine import PlanningProblem
from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.knowledge.literal import Literal
from planner.knowledge.operator import Operator
from planner.statics import Statics


def why_unsolvable(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> str:
    """What stands in each goal's way, else that no plan exists."""
    statics = Statics(knowledge_base, problem)
    found = [
        obstacle
        for goal in problem.goals
        if goal not in problem.facts
        for obstacle in _obstacles(knowledge_base, problem, statics, goal)
    ]
    return "; ".join(dict.fromkeys(found)) or "no plan exists from the present facts"


def _obstacles(
    knowledge_base: KnowledgeBase, problem: PlanningProblem, statics: Statics, goal: Fact
) -> Iterator[str]:
    achievers = [
        op
        for op in knowledge_base.operators
        if any(_matches(knowledge_base, problem, literal, goal, op) for literal in op.intended_effects)
    ]
    if not achievers:
        by_the_way = any(
            _matches(knowledge_base, problem, literal, goal, op)
            for op in knowledge_base.operators
            for literal in op.other_effects
        )
        hint = ", it only comes about by the way" if by_the_way else ""
        yield f"no action has the intended effect {goal.predicate}{hint}"
        return
    yield from _lacking(statics, goal, achievers, problem)
    yield from _not_now(knowledge_base, problem, goal, achievers)
    for fact in sorted(problem.facts - statics.facts):
        removers = [
            op
            for op in knowledge_base.operators
            if any(_matches(knowledge_base, problem, literal, fact, op) for literal in op.deletes)
        ]
        if fact.predicate == goal.predicate and fact.args[:1] == goal.args[:1] and removers:
            yield from _lacking(statics, fact, removers, problem)


def _not_now(
    knowledge_base: KnowledgeBase, problem: PlanningProblem, goal: Fact, achievers: list[Operator]
) -> Iterator[str]:
    """Conditions that the goal alone determines and that do not hold at present."""
    absent: list[set[Fact]] = []
    for op in achievers:
        for literal in op.intended_effects:
            if _matches(knowledge_base, problem, literal, goal, op):
                binding = dict(zip(literal.terms, goal.args, strict=True))
                open_terms = op.parameters.keys() - binding.keys()
                bound = [need for need in op.preconditions if open_terms.isdisjoint(need.terms)]
                absent.append({need.ground(binding) for need in bound} - problem.facts)
    for fact in sorted(set.intersection(*absent)) if absent else ():
        yield f"{fact} does not hold"


def _lacking(
    statics: Statics, fact: Fact, operators: list[Operator], problem: PlanningProblem
) -> Iterator[str]:
    """For each thing of the fact that robots relate to: is there a robot for one of these operators?"""
    tags = sorted({op.spec.name for op in operators})
    able = [robot for robot in statics.robots if any(tag in statics.related(robot) for tag in tags)]
    if not able:
        yield f"no robot can {' or '.join(tags)}"
    kinds = {problem.objects.get(arg) for robot in statics.robots for arg in statics.related(robot)}
    for arg in fact.args:
        is_place = arg in problem.objects and problem.objects[arg] in kinds and arg not in statics.robots
        if is_place and not any(arg in statics.related(robot) for robot in able):
            yield f"no robot that can {' or '.join(tags)} reaches {arg}"


def _matches(
    knowledge_base: KnowledgeBase, problem: PlanningProblem, literal: Literal, fact: Fact, op: Operator
) -> bool:
    return literal.predicate == fact.predicate and all(
        knowledge_base.file.is_a(problem.objects.get(arg, ""), op.parameters[term])
        if term in op.parameters
        else term == arg
        for term, arg in zip(literal.terms, fact.args, strict=True)
    )
