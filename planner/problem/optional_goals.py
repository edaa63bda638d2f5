"""Problems with optional goals: without them, and with those that a plan-net achieves."""

from dataclasses import replace

from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import PlanningProblem


def without_optional(problem: PlanningProblem) -> PlanningProblem:
    """The problem of the goals that must be achieved."""
    goals = tuple(goal for goal in problem.goals if goal not in problem.values)
    return replace(problem, goals=goals, values={})


def with_goals_of(plan_net: PlanNet, problem: PlanningProblem) -> PlanningProblem:
    """The problem without the optional goals that a plan-net leaves out; the others are not optional."""
    if not problem.values:
        return problem
    goals = tuple(goal for goal in problem.goals if goal not in problem.values or goal in plan_net.goals)
    return replace(problem, goals=goals, values={})
