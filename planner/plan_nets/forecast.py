"""When a plan-net's goals are likely achieved: distributions of completion times, and the chance to keep deadlines.

How they are found is in `planner.plan_nets.completion`; here is what they say, without numerical libraries.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from planner.fact import Fact

Kind = tuple[str, int]
"""An action's tag and the number of agents that do it together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """How far a kind of action's durations vary about the expected one.

    :param relative: standard deviation as a share of the expected duration.
    :param observations: how many observations the expectation and this rest on, the prior's three included; few mean
        that both are uncertain themselves, for all actions of the kind alike.
    """

    relative: float = 0.3
    observations: float = 3.0

    def __post_init__(self) -> None:
        """:raises ValueError: if the spread is negative or rests on nothing."""
        if self.relative < 0 or self.observations <= 0:
            raise ValueError(f"a spread needs relative >= 0 and observations > 0, not {self}")


PRIOR_SPREAD = Spread()
"""Of a kind that nothing is known of (our choice, as `app.domain.durations`)."""
Spreads = Mapping[Kind, Spread]
"""By kind; `PRIOR_SPREAD` of those that are left out."""

PROBABILITIES = (0.0, 0.01, 0.02, 0.05, *(round(0.05 * step, 2) for step in range(2, 20)), 0.98, 0.99, 1.0)
"""What the quantiles of a distribution belong to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """A distribution by its quantiles.

    :param quantiles: one for each of `PROBABILITIES`, ascending.
    """

    quantiles: tuple[float, ...]

    def __post_init__(self) -> None:
        """:raises ValueError: if there is not one quantile for each probability."""
        if len(self.quantiles) != len(PROBABILITIES):
            raise ValueError(f"{len(self.quantiles)} quantiles for {len(PROBABILITIES)} probabilities")

    def quantile(self, probability: float) -> float:
        """:raises ValueError: if it is not one of `PROBABILITIES`."""
        return self.quantiles[PROBABILITIES.index(probability)]

    def probability_up_to(self, value: float) -> float:
        """The probability of at most this value, linear between the quantiles."""
        place = sum(quantile <= value for quantile in self.quantiles)
        if place == 0:
            return 0.0
        if place == len(self.quantiles):
            return 1.0
        low, high = self.quantiles[place - 1 : place + 1]
        part = (value - low) / (high - low)
        below, above = PROBABILITIES[place - 1 : place + 1]
        return below + part * (above - below)


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalForecast:
    """When a goal is achieved for good.

    :param completion_s: seconds from the plan's start.
    :param deadline_s: likewise; None if it has none.
    """

    goal: Fact
    completion_s: Distribution
    deadline_s: float | None = None

    def on_time(self, delay_s: float = 0.0) -> float | None:
        """The probability that it is achieved by its deadline; None if it has none.

        :param delay_s: how much later the plan starts than it was to.
        """
        if self.deadline_s is None:
            return None
        return self.completion_s.probability_up_to(self.deadline_s - delay_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """Of all goals of a plan-net.

    :param lateness_s: how late the latest goal is, negative: early; None if no goal has a deadline.
    """

    goals: tuple[GoalForecast, ...]
    lateness_s: Distribution | None = None

    def on_time(self, delay_s: float = 0.0) -> float | None:
        """The probability that every goal is achieved by its deadline; None if none has one."""
        return None if self.lateness_s is None else self.lateness_s.probability_up_to(-delay_s)
