"""The plan-net: a partial-order plan with causal links and time windows (MACTA §4).

Semantics: an action holds its pre-conditions from its start to its end (except what it deletes itself), its
deletes happen from its start on, its effects hold at its end. An ordering means: `before` ends before
`after` starts. An action that names times within it is there as its phases (`planner.knowledge.phases`), one after the
other by one robot, which may wait between them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.schedule import critical_path

INITIAL = "initial"
"""The producer of causal links from the initial state."""
GOAL = "goal"
"""The consumer of causal links to the goals."""
ROUNDING_S = 0.01
"""Times are rounded: what differs by less is the same."""


Senses = Mapping[str, frozenset[str]]
"""By robot, the predicates in rel/ref form that it perceives; one that is left out perceives all that are sensed."""


class Keeping(StrEnum):
    """What keeps an ordering while robots carry the plan out alone."""

    ROBOT = "robot"  # the robot's own order of actions
    SENSING = "sensing"  # the later robot senses what the earlier action brings about
    CLEARANCE = "clearance"  # the later robot waits until the mission organiser clears it


class OrderingReason(StrEnum):
    """Why one action is ordered before another."""

    CAUSAL = "causal"  # the earlier action brings about what the later one needs
    THREAT = "threat"  # in the other order, one would delete the fact of a causal link
    RESOURCE = "resource"  # the same robot does both
    STAGE = "stage"  # the earlier action achieves a goal that comes before those of the later one
    ORDER = (
        "order"  # the later action achieves a goal that is to come true only after that of the earlier one
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanNetAction(GroundAction):
    """A ground plan-net action (table 3) with its time window, seconds from the plan's start.

    `not_before_s`: it starts then at the earliest, as it achieves a goal that is not to be true before; 0: any time.
    """

    id: str
    earliest_start_s: float
    latest_start_s: float
    description: str
    not_before_s: float = 0.0

    def unscheduled(self) -> GroundAction:
        """The action without its time window and id."""
        return GroundAction(**{name: getattr(self, name) for name in GroundAction.__dataclass_fields__})

    @property
    def earliest_end_s(self) -> float:
        return round(self.earliest_start_s + self.duration_s, 3)

    @property
    def slack_s(self) -> float:
        return round(self.latest_start_s - self.earliest_start_s, 3)

    @property
    def critical(self) -> bool:
        """True if it cannot start later without the plan, or a goal with a deadline, being later."""
        return self.slack_s < ROUNDING_S


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class CausalLink:
    """`producer` brings about `fact`, which `consumer` needs; nothing may delete it in between."""

    producer: str
    fact: Fact
    consumer: str


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Ordering:
    """`before` ends before `after` starts."""

    before: str
    after: str
    reason: OrderingReason
    kept_by: Keeping | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanNet:
    """A whole plan.

    `recruitment` says for each robot used why it was chosen; `late` by how many seconds goals miss their
    deadlines, if any do; `senses` what robots perceive, of those that do not perceive all that is sensed.
    """

    goals: tuple[Fact, ...]
    actions: tuple[PlanNetAction, ...]
    causal_links: tuple[CausalLink, ...]
    orderings: tuple[Ordering, ...]
    recruitment: Mapping[str, str]
    late: Mapping[Fact, float] = field(default_factory=dict)
    senses: Senses = field(default_factory=dict)

    @property
    def makespan_s(self) -> float:
        return max((action.earliest_end_s for action in self.actions), default=0.0)

    @property
    def late_s(self) -> float:
        """By how much goals miss their deadlines, together."""
        return sum(self.late.values())

    @property
    def distance_m(self) -> float:
        """Driven by all robots together."""
        return round(sum(action.distance_m for action in self.actions), 3)

    @property
    def energy_j(self) -> float:
        """Used by all robots together."""
        return round(sum(action.energy_j for action in self.actions), 3)

    @property
    def clearances(self) -> int:
        """For how many orderings a robot waits until it is cleared; without any the robots need no contact."""
        return sum(ordering.kept_by is Keeping.CLEARANCE for ordering in self.orderings)

    @property
    def critical_path(self) -> tuple[str, ...]:
        """The ids of a longest chain of actions, in order: what the makespan is made of."""
        number = {action.id: place for place, action in enumerate(self.actions)}
        path = critical_path(
            [action.duration_s for action in self.actions],
            [action.earliest_start_s for action in self.actions],
            [(number[ordering.before], number[ordering.after]) for ordering in self.orderings],
        )
        return tuple(self.actions[place].id for place in path)

    @property
    def robots(self) -> tuple[str, ...]:
        return tuple(sorted({agent for action in self.actions for agent in action.agents}))

    def action(self, action_id: str) -> PlanNetAction:
        return next(action for action in self.actions if action.id == action_id)

    def of_robot(self, robot: str) -> tuple[PlanNetAction, ...]:
        """The robot's actions in order of their start."""
        mine = [action for action in self.actions if robot in action.agents]
        return tuple(sorted(mine, key=lambda action: action.earliest_start_s))
