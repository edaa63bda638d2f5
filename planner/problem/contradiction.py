"""Goals that can never hold together, proven from the knowledge base's invariants."""

from collections import defaultdict
from itertools import combinations

from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.problem.interface import PlanningProblem


def contradicting_goals(
    knowledge_base: KnowledgeBase, problem: PlanningProblem
) -> tuple[tuple[Fact, Fact], ...]:
    """The pairs of goals of which at most one can be true at a time; with one of them, there is no plan.

    Two samples in a place with room for one, or a robot in two places: values of one variable
    (`planner.knowledge.invariants`) that has one value among the present facts. Not all contradictions are found.
    """
    from planner.knowledge.invariants import variables_of

    about: dict[str, list[Fact]] = defaultdict(list)
    for goal in dict.fromkeys(problem.goals):
        for name in dict.fromkeys(goal.args):
            about[name].append(goal)
    present = frozenset(problem.objects.values())
    found: dict[tuple[Fact, Fact], None] = {}
    for name, goals in about.items():
        if len(goals) > 1 and name in problem.objects:
            for variable in variables_of(knowledge_base, frozenset({problem.objects[name]}), present):
                values = [goal for goal in goals if variable.has(goal.predicate, goal.args, name)]
                if len(values) > 1 and variable.is_single(problem.facts, name):
                    found |= dict.fromkeys(combinations(values, 2))
    return tuple(found)
