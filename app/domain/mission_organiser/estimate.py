"""The margin: time that a mission may take beyond its estimate before the robots are asked (MACTA §4)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import sqrt

from app.domain.durations import PRIOR, Durations
from app.domain.mission_organiser.synchronisation import message_count
from planner import PlanNet

ENOUGH = 5
"""The learned spread is used once there are this many samples of each action on the critical path."""
DEVIATIONS = 3.0
"""How many standard deviations of the mission's duration the margin covers (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """The time that a mission may take beyond its estimate: by the learned spreads, but at least `absolute_s`.

    Until enough is learned: `relative` times the estimate, plus `absolute_s`. In both cases the time of the radio is
    added: `answers_s` is, by world, how long a message to a robot and its answer may take.
    """

    relative: float = 0.5
    absolute_s: float = 20.0
    answers_s: Mapping[str, float] = field(default_factory=dict)

    def of(self, plan_net: PlanNet, learned: Durations, world: str = "") -> float:
        """The margin in seconds."""
        return self._of_work(plan_net, learned) + message_count(plan_net) * self.answers_s.get(world, 0.0)

    def _of_work(self, plan_net: PlanNet, learned: Durations) -> float:
        """The margin without the radio's. Durations along the critical path vary independently (our choice)."""
        critical = [plan_net.action(action_id) for action_id in plan_net.critical_path]
        known = [learned.get((action.tag, len(action.agents)), PRIOR) for action in critical]
        if any(one.samples < ENOUGH for one in known):
            return self.relative * plan_net.makespan_s + self.absolute_s
        spans = zip(critical, known, strict=True)
        variance = sum((action.duration_s * one.relative_spread) ** 2 for action, one in spans)
        return max(self.absolute_s, DEVIATIONS * sqrt(variance))
