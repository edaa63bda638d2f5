"""What the constraints on a plan cost: how much sooner the goals would be achieved without each of them."""

from collections.abc import Mapping
from dataclasses import dataclass

from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import PlanningProblem
from planner.problem.solving import TimeLimitedEngine

EQUAL_S = 0.05
"""Makespans that differ by less count as equal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstraintCost:
    """What a constraint costs a plan that keeps it.

    :param constraint: in words.
    :param at_least_s: by so much the shortest plan that was found without it is shorter; 0 if none is.
    :param at_most_s: by more no plan without it is shorter, by a proven bound; None if none is known.
    """

    constraint: str
    at_least_s: float
    at_most_s: float | None

    @property
    def words(self) -> str:
        if self.at_most_s is not None and self.at_most_s < EQUAL_S:
            return "it costs no time: no plan without it is shorter"
        most = (
            ""
            if self.at_most_s is None
            else f"; no plan without it is more than {self.at_most_s:.1f} s shorter"
        )
        if self.at_least_s < EQUAL_S:
            return f"no shorter plan without it was found{most}"
        if self.at_most_s is not None and self.at_most_s - self.at_least_s < EQUAL_S:
            return f"it costs {self.at_least_s:.1f} s: so much shorter is the shortest plan without it"
        return f"it costs {self.at_least_s:.1f} s at least: so much shorter is a plan without it{most}"


def constraint_costs(
    plan_net: PlanNet, without: Mapping[str, PlanningProblem], solving: TimeLimitedEngine
) -> tuple[ConstraintCost, ...]:
    """What each constraint costs; those that no time is left for are missing.

    The plan itself keeps all constraints, so it is a plan without any of them, too.

    :param without: by constraint, in words, the plan's problem without that one.
    """
    found: list[ConstraintCost] = []
    for constraint, problem in without.items():
        result = solving.plan_if_time(problem)
        if result is None:
            break
        other, bound_s = result.plan_net, result.lower_bound_s or None  # a bound of 0 says nothing
        shorter_s = 0.0 if other is None else max(plan_net.makespan_s - other.makespan_s, 0.0)
        most_s = None if bound_s is None else max(plan_net.makespan_s - bound_s, shorter_s)
        found.append(ConstraintCost(constraint=constraint, at_least_s=shorter_s, at_most_s=most_s))
    return tuple(found)
