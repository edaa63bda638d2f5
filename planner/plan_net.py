"""The plan-net: a partial-order plan with causal links and time windows (MACTA §4).

Semantics: an action holds its pre-conditions from its start to its end (except what it deletes itself), its
deletes happen from its start on, its effects hold at its end. An ordering means: `before` ends before
`after` starts.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from planner.fact import Fact

INITIAL = "initial"
"""The producer of causal links from the initial state."""
GOAL = "goal"
"""The consumer of causal links to the goals."""


class OrderingReason(StrEnum):
    CAUSAL = "causal"
    THREAT = "threat"
    RESOURCE = "resource"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanNetAction:
    """A ground plan-net action (table 3). Times in seconds from the plan's start."""

    id: str
    tag: str
    arguments: Mapping[str, str]
    agents: tuple[str, ...]
    preconditions: tuple[Fact, ...]
    deletes: tuple[Fact, ...]
    intended_effects: tuple[Fact, ...]
    other_effects: tuple[Fact, ...]
    duration_s: float
    earliest_start_s: float
    latest_start_s: float
    description: str

    @property
    def effects(self) -> tuple[Fact, ...]:
        return self.intended_effects + self.other_effects

    @property
    def earliest_end_s(self) -> float:
        return self.earliest_start_s + self.duration_s

    @property
    def slack_s(self) -> float:
        return self.latest_start_s - self.earliest_start_s


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class CausalLink:
    """`producer` brings about `fact`, which `consumer` needs; nothing may delete it in between."""

    producer: str
    fact: Fact
    consumer: str


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Ordering:
    before: str
    after: str
    reason: OrderingReason


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanNet:
    """A whole plan. `recruitment` says for each robot used why it was chosen."""

    goals: tuple[Fact, ...]
    actions: tuple[PlanNetAction, ...]
    causal_links: tuple[CausalLink, ...]
    orderings: tuple[Ordering, ...]
    recruitment: Mapping[str, str]

    @property
    def makespan_s(self) -> float:
        return max((action.earliest_end_s for action in self.actions), default=0.0)

    @property
    def robots(self) -> tuple[str, ...]:
        return tuple(sorted({agent for action in self.actions for agent in action.agents}))

    def action(self, action_id: str) -> PlanNetAction:
        return next(action for action in self.actions if action.id == action_id)

    def of_robot(self, robot: str) -> tuple[PlanNetAction, ...]:
        """The robot's actions in order of their start."""
        mine = [action for action in self.actions if robot in action.agents]
        return tuple(sorted(mine, key=lambda action: action.earliest_start_s))
