"""Forecasts: when goals are likely achieved, from how far durations vary."""

from dataclasses import replace
from math import exp, log, sqrt

import numpy as np
import pytest

from planner import (
    GOAL,
    INITIAL,
    CausalLink,
    Distribution,
    Fact,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
    Spread,
)
from planner.errors import CyclicOrder
from planner.plan_nets.completion import completion_samples, forecast
from planner.plan_nets.forecast import PROBABILITIES

FIRST, SECOND, BOTH = (Fact("done", (name,)) for name in ("first", "second", "both"))
KNOWN = 10_000.0
"""So many observations that nothing about a kind is uncertain."""
Z90 = 1.2816
"""The standard normal distribution's quantile of 90 %."""


def action(
    number: int, goal: Fact, *, tag: str = "WORK", robot: str = "", takes_s: float = 10.0
) -> PlanNetAction:
    return PlanNetAction(
        id=f"a{number}",
        tag=tag,
        arguments={"job": goal.args[0]},
        agents=(robot or f"robot_{number}",),
        preconditions=(),
        deletes=(),
        intended_effects=(goal,),
        other_effects=(),
        duration_s=takes_s,
        earliest_start_s=0.0,
        latest_start_s=0.0,
        description="",
    )


def net(*actions: PlanNetAction, order: tuple[str, ...] = (), initial: tuple[Fact, ...] = ()) -> PlanNet:
    """A plan-net in which every action achieves a goal; `order` has pairs such as "a1<a2"."""
    achieved = {one.intended_effects[0]: one.id for one in actions} | dict.fromkeys(initial, INITIAL)
    pairs = [pair.split("<") for pair in order]
    return PlanNet(
        goals=tuple(achieved),
        actions=actions,
        causal_links=tuple(
            CausalLink(producer=producer, fact=fact, consumer=GOAL) for fact, producer in achieved.items()
        ),
        orderings=tuple(
            Ordering(before=before, after=after, reason=OrderingReason.RESOURCE) for before, after in pairs
        ),
        recruitment={},
    )


def spread(relative: float, observations: float = KNOWN) -> dict[tuple[str, int], Spread]:
    return {("WORK", 1): Spread(relative=relative, observations=observations)}


CHAIN = net(action(1, FIRST), action(2, SECOND), order=("a1<a2",))
JOINED = net(action(1, FIRST), action(2, SECOND), action(3, BOTH), order=("a1<a3", "a2<a3"))


def test_what_does_not_vary_ends_as_planned() -> None:
    times = completion_samples(CHAIN, spread(0.0), samples=8)
    assert times[FIRST].tolist() == [10.0] * 8
    assert times[SECOND].tolist() == [20.0] * 8


def test_one_well_known_action_is_log_normal_about_its_expected_duration() -> None:
    relative = 0.4
    likely = forecast(net(action(1, FIRST)), {}, spread(relative)).goals[0].completion_s
    deviation = sqrt(log(1 + relative**2))
    for probability, z in ((0.1, -Z90), (0.5, 0.0), (0.9, Z90)):
        expected_s = 10.0 * exp(-(deviation**2) / 2 + z * deviation)
        assert likely.quantile(probability) == pytest.approx(expected_s, rel=0.03)
    samples = completion_samples(net(action(1, FIRST)), spread(relative))[FIRST]
    assert float(samples.mean()) == pytest.approx(10.0, rel=0.02)


def test_who_waits_for_two_waits_for_the_later_one() -> None:
    times = completion_samples(JOINED, spread(0.3))
    work_s = times[BOTH] - np.maximum(times[FIRST], times[SECOND])
    assert float(work_s.min()) > 0
    assert float(np.median(times[BOTH])) > 20.5  # the shortest plan says 20 s
    alone = completion_samples(net(action(3, BOTH)), spread(0.3))[BOTH]
    assert np.allclose(work_s, alone, atol=1e-3)


def test_a_coupling_less_makes_no_goal_later_in_any_sample() -> None:
    loose = replace(JOINED, orderings=JOINED.orderings[:1])
    coupled, uncoupled = (completion_samples(one, spread(0.3)) for one in (JOINED, loose))
    assert all((uncoupled[goal] <= coupled[goal]).all() for goal in JOINED.goals)
    assert (uncoupled[BOTH] < coupled[BOTH]).any()


def test_what_a_causal_link_asks_for_is_waited_for_without_an_ordering() -> None:
    link = CausalLink(producer="a1", fact=FIRST, consumer="a2")
    linked = replace(CHAIN, orderings=(), causal_links=(*CHAIN.causal_links, link))
    assert completion_samples(linked, spread(0.0), samples=1)[SECOND].tolist() == [20.0]


def test_the_less_is_known_the_wider_is_the_forecast() -> None:
    def width_s(observations: float) -> float:
        likely = forecast(net(action(1, FIRST)), {}, spread(0.3, observations)).goals[0].completion_s
        return likely.quantile(0.95) - likely.quantile(0.05)

    assert width_s(3) > 1.2 * width_s(10) > 1.2 * width_s(KNOWN)


def test_what_is_not_known_of_a_kind_concerns_all_its_actions_alike() -> None:
    """Well-known delays even out along a chain; a kind that takes longer than believed does so every time."""
    names = [Fact("done", (f"job_{number}",)) for number in range(16)]
    actions = [action(number, goal, robot="robot") for number, goal in enumerate(names)]
    chain = net(*actions, order=tuple(f"a{n}<a{n + 1}" for n in range(15)))

    def relative_width(observations: float) -> float:
        times = completion_samples(chain, spread(0.3, observations))[names[-1]]
        return float(np.quantile(times, 0.9) - np.quantile(times, 0.1)) / float(np.median(times))

    assert relative_width(KNOWN) == pytest.approx(2 * Z90 * 0.3 / 4, rel=0.1)
    assert relative_width(4) > 2 * relative_width(KNOWN)


def test_the_same_plan_has_the_same_forecast_and_shares_its_luck_with_others() -> None:
    assert completion_samples(JOINED, {})[BOTH].tolist() == completion_samples(JOINED, {})[BOTH].tolist()
    assert completion_samples(CHAIN, {})[FIRST].tolist() == completion_samples(JOINED, {})[FIRST].tolist()
    other = completion_samples(CHAIN, {}, seed=1)[FIRST]
    assert other.tolist() != completion_samples(CHAIN, {})[FIRST].tolist()


def test_a_robot_that_does_the_same_twice_is_not_equally_lucky_twice() -> None:
    twice = net(
        action(1, FIRST, robot="robot"),
        replace(action(2, SECOND, robot="robot"), arguments={"job": "first"}),
        order=("a1<a2",),
    )
    times = completion_samples(twice, spread(0.3))
    assert abs(float(np.corrcoef(times[FIRST], times[SECOND] - times[FIRST])[0, 1])) < 0.1


def test_what_holds_already_is_on_time_even_now() -> None:
    likely = forecast(net(initial=(FIRST,)), {FIRST: 0.0}, {})
    assert likely.goals[0].on_time() == 1.0
    assert likely.on_time() == 1.0
    assert likely.on_time(delay_s=0.1) == 0.0


def test_all_deadlines_together_are_kept_no_likelier_than_each() -> None:
    due = {FIRST: 11.0, SECOND: 21.0}
    likely = forecast(CHAIN, due, spread(0.3))
    each = [goal.on_time() for goal in likely.goals]
    together = likely.on_time()
    assert together is not None
    assert all(one is not None and together <= one for one in each)
    times = completion_samples(CHAIN, spread(0.3))
    kept = np.mean((times[FIRST] <= 11.0) & (times[SECOND] <= 21.0))
    assert together == pytest.approx(float(kept), abs=0.01)


def test_the_chance_sinks_while_a_plan_waits() -> None:
    likely = forecast(CHAIN, {SECOND: 25.0}, spread(0.3))
    chances = [likely.on_time(delay_s) for delay_s in (0.0, 2.0, 5.0, 30.0)]
    assert chances == sorted(chances, reverse=True)
    assert chances[0] == likely.goals[1].on_time()
    assert chances[-1] == 0.0
    assert likely.goals[0].on_time() is None


def test_without_deadlines_nothing_is_late() -> None:
    assert forecast(CHAIN, {}, {}).on_time() is None


def test_probabilities_between_quantiles_are_close_to_those_of_the_samples() -> None:
    times = completion_samples(CHAIN, spread(0.4))[SECOND]
    likely = forecast(CHAIN, {}, spread(0.4)).goals[1].completion_s
    for by_s in np.linspace(8, 50, 60):
        assert likely.probability_up_to(float(by_s)) == pytest.approx(float((times <= by_s).mean()), abs=0.01)


def test_a_distribution_needs_all_its_quantiles() -> None:
    assert len(Distribution(quantiles=(1.0,) * len(PROBABILITIES)).quantiles) == len(PROBABILITIES)
    with pytest.raises(ValueError, match="2 quantiles for"):
        Distribution(quantiles=(1.0, 2.0))
    with pytest.raises(ValueError, match="observations > 0"):
        Spread(observations=0)


def test_orderings_in_a_circle_have_no_forecast() -> None:
    with pytest.raises(CyclicOrder):
        forecast(net(action(1, FIRST), action(2, SECOND), order=("a1<a2", "a2<a1")), {}, {})
