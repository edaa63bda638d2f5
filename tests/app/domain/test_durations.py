"""What a run of actual durations teaches."""

from statistics import fmean, pvariance

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.domain.durations import MAX_RATIO, MAX_SAMPLES, MIN_RATIO, PRIOR, PRIOR_SPREAD, Learned

RATIOS = st.lists(st.floats(MIN_RATIO, MAX_RATIO), min_size=1, max_size=MAX_SAMPLES)


def after(*ratios: float) -> Learned:
    learned = PRIOR
    for ratio in ratios:
        learned = learned.with_sample(ratio)
    return learned


@given(RATIOS)
def test_running_mean_and_variance_are_those_of_all_samples(ratios: list[float]) -> None:
    learned = after(*ratios)
    assert learned.mean == pytest.approx(fmean(ratios))
    assert learned.variance == pytest.approx(pvariance(ratios), abs=1e-9)


def test_nothing_seen_changes_nothing() -> None:
    assert (PRIOR.factor, PRIOR.spread) == (1.0, PRIOR_SPREAD)


@given(RATIOS)
def test_the_factor_lies_between_1_and_the_mean(ratios: list[float]) -> None:
    learned = after(*ratios)
    low, high = sorted((1.0, learned.mean))
    assert low - 1e-9 <= learned.factor <= high + 1e-9


def test_one_sample_moves_the_factor_a_little_and_many_nearly_all_the_way() -> None:
    assert after(2.0).factor == pytest.approx(1.25)
    assert after(*[2.0] * 50).factor == pytest.approx(2.0, abs=0.06)


def test_a_steady_action_gets_a_small_spread_and_an_unsteady_one_keeps_a_large() -> None:
    assert after(*[1.1] * 50).spread < 0.1 < after(*[0.7, 1.5] * 25).spread


def test_an_odd_packet_counts_as_an_extreme_one_at_most() -> None:
    assert after(100.0) == after(MAX_RATIO)


def test_a_world_that_changes_is_learned_again() -> None:
    learned = after(*[1.0] * 10 * MAX_SAMPLES, *[2.0] * 3 * MAX_SAMPLES)
    assert learned.samples == MAX_SAMPLES
    assert learned.mean > 1.9
