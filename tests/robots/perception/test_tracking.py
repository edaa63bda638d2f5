"""Evidence grows with what any sensor tells and decays without; cursors stay on their things."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.perception.tracking import HALF_LIFE_S, Cursor, Modality, ObjectTracking, Observation

TICK_S = 0.05


def watch(
    seconds: float, *modalities: Modality, speed_m_s: float = 0.0, tracking: ObjectTracking | None = None
) -> Cursor:
    """The cursor of a ball that starts at (2, 1) and moves east, told with the modalities' noise."""
    tracking = tracking or ObjectTracking()
    rng = np.random.default_rng(1)
    for tick in range(round(seconds / TICK_S)):
        now_s = tick * TICK_S
        told = complex(2 + speed_m_s * now_s, 1) + complex(*rng.normal(0, 0.01, 2))
        tracking.observe([Observation.of_one("ball", one, told) for one in modalities], now_s)
    return tracking.cursors["ball"]


@settings(deadline=None)  # the first call compiles
@given(st.lists(st.sampled_from(list(Modality)), min_size=1, max_size=30))
def test_every_observation_adds_evidence_and_none_makes_it_certain(told: list[Modality]) -> None:
    tracking, before = ObjectTracking(), 0.0
    for one in told:
        tracking.observe([Observation.of_one("ball", one, 1j)], 0.0)
        evidence = tracking.cursors["ball"].evidence
        assert before < evidence <= 1
        before = evidence


def test_several_sensors_make_surer_than_one() -> None:
    alone = watch(0.2, Modality.ULTRASONIC).evidence
    both = watch(0.2, Modality.ULTRASONIC, Modality.INFRA_RED).evidence
    assert both > alone


def test_evidence_that_nothing_renews_halves_and_the_thing_is_forgotten() -> None:
    tracking = ObjectTracking()
    cursor = watch(2.0, Modality.INFRA_RED, tracking=tracking)
    assert cursor.evidence_at(cursor.seen_s + HALF_LIFE_S) == pytest.approx(cursor.evidence / 2)
    tracking.observe([], 60.0)
    assert "ball" not in tracking.cursors


def test_a_thing_that_moves_is_believed_to_and_one_at_rest_is_not() -> None:
    driving, resting = watch(3, Modality.INFRA_RED, speed_m_s=0.3), watch(3, Modality.INFRA_RED)
    assert driving.moving_at(3)
    assert driving.velocity.real == pytest.approx(0.3, abs=0.15)
    assert not resting.moving_at(3)


def test_the_place_is_estimated_better_than_by_one_look() -> None:
    rng = np.random.default_rng(3)
    tracking, off = ObjectTracking(), []
    for tick in range(100):
        told = 2 + 1j + complex(*rng.normal(0, 0.05, 2))
        tracking.observe([Observation.of_one("ball", Modality.INFRA_RED, told)], tick * TICK_S)
        off.append((abs(told - (2 + 1j)), abs(tracking.cursors["ball"].at - (2 + 1j))))
    told_off, believed_off = np.mean(off[20:], axis=0)
    assert believed_off < 0.7 * told_off


def test_a_short_look_away_does_not_break_a_view_and_a_long_one_does() -> None:
    for away_s, since_s in ((0.3, 0.0), (1.0, 1.95)):
        tracking = ObjectTracking()
        watch(1.0, Modality.INFRA_RED, tracking=tracking)
        back_s = 0.95 + away_s
        tracking.observe([Observation.of_one("ball", Modality.INFRA_RED, 2 + 1j)], back_s)
        assert tracking.cursors["ball"].in_view_since_s == pytest.approx(since_s)
