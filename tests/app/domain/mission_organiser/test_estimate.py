"""What a mission may take beyond its estimate before robots are asked."""

from math import sqrt

import pytest

from app.domain.durations import Learned
from app.domain.mission_organiser import Margin
from app.domain.mission_organiser.estimate import DEVIATIONS, ENOUGH
from tests.app.sample_store import Store

NET = Store().store_sample_1()
TAGS = {action.tag for action in NET.actions}
MARGIN = Margin(relative=0.5, absolute_s=20.0)
STEADY = Learned(samples=97, mean=1.0, variance=0.01)


def learned(**others: Learned) -> dict[tuple[str, int], Learned]:
    return {(tag, 1): others.get(tag, STEADY) for tag in TAGS}


def test_before_anything_is_learned_the_margin_is_a_part_of_the_estimate_and_seconds() -> None:
    assert MARGIN.of(NET, {}) == pytest.approx(0.5 * NET.makespan_s + 20)


def test_one_action_of_which_too_little_is_known_keeps_the_fixed_margin() -> None:
    few = Learned(samples=ENOUGH - 1, mean=1.0, variance=0.01)
    assert MARGIN.of(NET, learned(RELEASE2=few)) == MARGIN.of(NET, {})
    enough = Learned(samples=ENOUGH, mean=1.0, variance=0.01)
    assert MARGIN.of(NET, learned(RELEASE2=enough)) < MARGIN.of(NET, {})


def test_steady_actions_need_no_more_than_the_least_margin() -> None:
    assert MARGIN.of(NET, learned()) == 20.0


def test_the_margin_covers_the_deviations_along_the_critical_path() -> None:
    spans = [NET.action(action_id).duration_s for action_id in NET.critical_path]
    expected = DEVIATIONS * STEADY.relative_spread * sqrt(sum(span**2 for span in spans))
    assert Margin(relative=0.5, absolute_s=0.0).of(NET, learned()) == pytest.approx(expected)


def test_unsteady_actions_widen_the_margin() -> None:
    unsteady = Learned(samples=97, mean=1.0, variance=1.0)
    narrow = Margin(relative=0.5, absolute_s=0.0)
    assert narrow.of(NET, learned(TRANSPORT=unsteady)) > 2 * narrow.of(NET, learned())
