"""Preferences: constraints that a plan may break, each at a cost in seconds of makespan."""

from collections.abc import Sequence
from dataclasses import dataclass

from planner.fact import Fact
from planner.plan_nets.plan_net import PlanNet

MAX_PREFERENCES = 8
"""The most preferences of a problem."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Preference:
    """A constraint that a plan may break.

    :param words: the constraint.
    :param cost_s: seconds of makespan that keeping it is worth (> 0).
    :param withheld: no action of a plan that keeps it needs one of these facts.
    """

    words: str
    cost_s: float
    withheld: frozenset[Fact]

    def is_kept_by(self, plan_net: PlanNet) -> bool:
        return all(self.withheld.isdisjoint(action.preconditions) for action in plan_net.actions)


@dataclass(frozen=True, slots=True, kw_only=True)
class PreferenceOutcome:
    """Whether a plan keeps a preference.

    :param reason: why it is broken, in words; empty if it is kept.
    :param longer_s: by so much longer is the shortest plan found that keeps it beside those kept; None: none was found.
    :param longer_at_least_s: every such plan is longer by at least this much, by a proven bound; 0: nothing is proven.
    """

    words: str
    cost_s: float
    is_kept: bool
    reason: str = ""
    longer_s: float | None = None
    longer_at_least_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PreferenceChoice:
    """Which preferences a plan keeps.

    :param bound_s: no plan has a smaller sum of makespan and costs of broken preferences, as is proven; 0: nothing is.
    :param is_cut_short: a cheaper choice may have been missed, as not all that are promising were tried.
    """

    outcomes: tuple[PreferenceOutcome, ...]
    bound_s: float = 0.0
    is_cut_short: bool = False

    @property
    def cost_s(self) -> float:
        """Of the broken preferences together."""
        return sum(one.cost_s for one in self.outcomes if not one.is_kept)


def broken_cost_s(preferences: Sequence[Preference], plan_net: PlanNet) -> float:
    """What the preferences that a plan-net breaks cost together."""
    return sum(preference.cost_s for preference in preferences if not preference.is_kept_by(plan_net))


def judged(
    preferences: Sequence[Preference], plan_net: PlanNet, *, otherwise: str
) -> tuple[PreferenceOutcome, ...]:
    """Which of the preferences a plan-net keeps, without planning.

    :param otherwise: the reason of those that it breaks.
    """
    kept = [preference.is_kept_by(plan_net) for preference in preferences]
    return tuple(
        PreferenceOutcome(
            words=preference.words,
            cost_s=preference.cost_s,
            is_kept=is_kept,
            reason="" if is_kept else otherwise,
        )
        for preference, is_kept in zip(preferences, kept, strict=True)
    )
