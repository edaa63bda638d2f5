"""Problems with optional goals or preferences: without these, and as a plan-net has chosen."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from planner.fact import Fact
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import PlanningProblem
from planner.problem.preference import Preference


def without_optional(problem: PlanningProblem) -> PlanningProblem:
    """The problem of the goals that must be achieved."""
    goals = tuple(goal for goal in problem.goals if goal not in problem.values)
    return replace(problem, goals=goals, values={})


def keeping(problem: PlanningProblem, preferences: Iterable[Preference]) -> PlanningProblem:
    """The problem of plans that keep these of its preferences; the others do not count."""
    withheld = frozenset[Fact]().union(*(preference.withheld for preference in preferences))
    return replace(problem, facts=problem.facts - withheld, preferences=())


def with_goals_of(plan_net: PlanNet, problem: PlanningProblem) -> PlanningProblem:
    """The problem without the optional goals that a plan-net leaves out; the others are not optional."""
    goals = tuple(goal for goal in problem.goals if goal not in problem.values or goal in plan_net.goals)
    return replace(problem, goals=goals, values={})


def as_chosen_by(plan_net: PlanNet, problem: PlanningProblem) -> PlanningProblem:
    """The problem without the optional goals that a plan-net leaves out, with the preferences it keeps required."""
    kept = [preference for preference in problem.preferences if preference.is_kept_by(plan_net)]
    return keeping(with_goals_of(plan_net, problem), kept)


def without_each_preference(
    plan_net: PlanNet, problem: PlanningProblem
) -> Iterator[tuple[str, PlanningProblem]]:
    """For each preference that a plan-net keeps, in words, the problem of plans that keep the others that it keeps."""
    for preference in problem.preferences:
        if preference.is_kept_by(plan_net):
            others = tuple(other for other in problem.preferences if other is not preference)
            yield preference.words, as_chosen_by(plan_net, replace(problem, preferences=others))
