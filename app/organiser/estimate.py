"""The time a mission is expected to take, and when after it the robots are asked (MACTA §4)."""

from dataclasses import dataclass

from planner import PlanNet


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """What a mission may take beyond its estimate before the robots are asked: a part of it, and seconds."""

    relative: float = 0.5
    absolute_s: float = 20.0

    def of(self, estimate_s: float) -> float:
        """The margin in seconds."""
        return self.relative * estimate_s + self.absolute_s


def estimate_s(plan_net: PlanNet) -> float:
    """The plan-net's makespan: every action starts as early as its orderings allow."""
    return plan_net.makespan_s


def enquiry_at_s(start_s: float, estimate_s: float, margin: Margin) -> float:
    """When the robots are asked, in the clock of `start_s`."""
    return start_s + estimate_s + margin.of(estimate_s)
