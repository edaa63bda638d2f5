"""Samples when a plan-net's goals are achieved: Monte-Carlo over its longest paths (stochastic PERT; Van Slyke 1963).

Robots begin each action as soon as its couplings allow, whatever keeps them (own order, sensing, clearance), so an
action starts at the latest end of what is ordered before it, and a goal is achieved at the end of the action that
brings it about for good.

Durations: for each kind of action a normal-inverse-chi-squared posterior (Gelman et al., Bayesian Data Analysis, §3.3)
on the logarithm of the ratio of actual to expected duration, so that the ratio is log-normal if much is known. With
n observations and relative spread c, s² = ln(1 + c²):

    σ² = n s² / χ²(n),   μ ~ N(-σ²/2, σ²/n)   one of each for a kind and a sample, as what is not known of a kind
                                              concerns all its actions alike
    ratio = exp(μ + σ z),   z ~ N(0, 1)       one for each action

What is learned is the mean ratio, so that is 1 whatever σ (hence -σ²/2, our choice), but for the uncertainty of μ.

Our choices: ratios are clamped as learned ones are; actions of a kind vary independently but for μ and σ. What is not
in it: actions that fail, and the time that messages take.

The random numbers of an action depend on what it does, not on where it stands: the same plan-net has the same forecast,
and two plans are compared with the same luck for what they have in common (common random numbers).
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from hashlib import blake2b

import numpy as np
import numpy.typing as npt

from planner.fact import Fact
from planner.plan_nets.forecast import (
    PRIOR_SPREAD,
    PROBABILITIES,
    Distribution,
    Forecast,
    GoalForecast,
    Kind,
    Spreads,
)
from planner.plan_nets.plan_net import GOAL, INITIAL, PlanNet, PlanNetAction
from planner.plan_nets.precedence import topological

SAMPLES = 4096
MIN_RATIO = 0.25
MAX_RATIO = 4.0
"""As `app.domain.durations` clamps what is learned."""

Samples = npt.NDArray[np.float32]
"""Shape (samples,), seconds."""


def forecast(
    plan_net: PlanNet,
    deadlines_s: Mapping[Fact, float],
    spreads: Spreads,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
) -> Forecast:
    """When the goals are likely achieved.

    :param deadlines_s: seconds from the plan's start; of facts that are no goals of the plan-net ignored.
    :raises CyclicOrder: if the plan-net's orderings contradict each other.
    """
    found = completion_samples(plan_net, spreads, samples=samples, seed=seed)
    due = [goal for goal in found if goal in deadlines_s]
    lateness = np.max([found[goal] - deadlines_s[goal] for goal in due], axis=0) if due else None
    return Forecast(
        goals=tuple(
            GoalForecast(goal=goal, completion_s=_distribution(times), deadline_s=deadlines_s.get(goal))
            for goal, times in found.items()
        ),
        lateness_s=None if lateness is None else _distribution(lateness),
    )


def completion_samples(
    plan_net: PlanNet, spreads: Spreads, *, samples: int = SAMPLES, seed: int = 0
) -> dict[Fact, Samples]:
    """For each goal the times at which it is achieved, shape (samples,), seconds from the plan's start.

    Sample i of all goals belongs together.

    :raises CyclicOrder: if the plan-net's orderings contradict each other.
    """
    number = {action.id: place for place, action in enumerate(plan_net.actions)}
    achievers = {link.fact: link.producer for link in plan_net.causal_links if link.consumer == GOAL}
    ends = _ends(plan_net, number, _Durations(spreads, samples, seed))
    at_once = np.zeros(samples, dtype=np.float32)
    by = {goal: achievers.get(goal, INITIAL) for goal in plan_net.goals}
    return {goal: at_once if one == INITIAL else ends[number[one]] for goal, one in by.items()}


def _ends(plan_net: PlanNet, number: Mapping[str, int], durations: "_Durations") -> Sequence[Samples]:
    """The actions' ends: the longest paths to them."""
    following: list[set[int]] = [set() for _ in number]
    for before, after in _pairs(plan_net):
        following[number[before]].add(number[after])
    ends = [np.full(durations.count, action.not_before_s, dtype=np.float32) for action in plan_net.actions]
    for place in topological(following):
        # Until now it held the start: the latest end of what comes before.
        ends[place] += durations.of(plan_net.actions[place])
        for other in following[place]:
            np.maximum(ends[other], ends[place], out=ends[other])
    return ends


def _pairs(plan_net: PlanNet) -> Iterable[tuple[str, str]]:
    yield from ((ordering.before, ordering.after) for ordering in plan_net.orderings)
    for link in plan_net.causal_links:
        if link.producer != INITIAL and link.consumer != GOAL:
            yield link.producer, link.consumer


class _Durations:
    """Samples of actions' durations."""

    def __init__(self, spreads: Spreads, count: int, seed: int) -> None:
        self.count = count
        self._spreads = spreads
        self._seed = seed
        self._of_kind = cache(self._sampled_kind)
        self._met: Counter[tuple[str, ...]] = Counter()

    def of(self, action: PlanNetAction) -> Samples:
        """Shape (samples,), seconds."""
        centre, scale = self._of_kind((action.tag, len(action.agents)))
        what = (action.tag, *action.agents, *action.arguments.values(), str(action.phase))
        self._met[what] += 1
        chance = self._chance(*what, str(self._met[what]))
        ratio = np.exp(centre + scale * chance.standard_normal(self.count, dtype=np.float32))
        return (action.duration_s * np.clip(ratio, MIN_RATIO, MAX_RATIO)).astype(np.float32)

    def _sampled_kind(self, kind: Kind) -> tuple[Samples, Samples]:
        """μ and σ of the kind, shape (samples,) each."""
        spread = self._spreads.get(kind, PRIOR_SPREAD)
        chance = self._chance(kind[0], str(kind[1]))
        variance = float(np.log1p(spread.relative**2))
        odds = chance.chisquare(spread.observations, self.count)
        scale = np.sqrt(variance * spread.observations / odds)
        luck = chance.standard_normal(self.count)
        centre = scale / np.sqrt(spread.observations) * luck - scale**2 / 2
        return centre.astype(np.float32), scale.astype(np.float32)

    def _chance(self, *words: str) -> np.random.Generator:
        digest = blake2b("\0".join((str(self._seed), *words)).encode(), digest_size=16).digest()
        return np.random.default_rng(int.from_bytes(digest))


def _distribution(samples: Samples) -> Distribution:
    quantiles = np.quantile(samples, PROBABILITIES)
    return Distribution(quantiles=tuple(round(float(one), 3) for one in quantiles))
