"""Sensor conditions say whether they hold and what was perceived."""

import pytest

from robots.conditions.composition import AnyOf, Not, unmet
from robots.conditions.facts import condition_for
from robots.conditions.own_state import Empty, Holding
from robots.conditions.position import Near
from robots.conditions.sight import Clear, InView, LiesAt, Vacant
from robots.errors import RepertoireError
from tests.robots.sensed import PROFILE, percepts, readings, sees, watch
from tests.robots.stories import fact

BAY = sees("bay", 2.0)


def test_near_is_the_approach_point_facing_the_beacon() -> None:
    near = Near(place="bay")
    assert near.check(percepts(sees("bay", 0.85, 0.05))).holds
    assert not near.check(percepts(sees("bay", 1.0))).holds
    assert not near.check(percepts(sees("bay", 0.8, 0.3))).holds
    assert not near.check(percepts(sees("bay", 0.8, 0.0, 0.4))).holds


def test_a_sample_lies_at_a_place_when_its_tag_is_seen_still_by_the_beacon() -> None:
    condition = LiesAt(object="sample", place="bay")
    assert condition.check(percepts(BAY, sees("sample", 1.95))).holds
    assert not condition.check(percepts(BAY, sees("sample", 1.5))).holds
    assert not condition.check(percepts(BAY)).holds


def test_a_sample_that_moves_does_not_lie() -> None:
    moving = [readings(BAY, sees("sample", 1.8 + 0.02 * tick)) for tick in range(12)]
    assert not LiesAt(object="sample", place="bay").check(watch(moving)).holds


def test_a_sample_that_a_robot_still_brings_does_not_lie_there_yet() -> None:
    brought = percepts(BAY, sees("sample", 2.0), sees("other", 2.34))
    verdict = LiesAt(object="sample", place="bay").check(brought)
    assert not verdict.holds
    assert "other still by it" in verdict.words
    assert LiesAt(object="sample", place="bay", left=False).check(brought).holds


def test_a_place_is_vacant_when_its_beacon_is_seen_and_no_foreign_tag() -> None:
    vacant = Vacant(place="bay")
    assert vacant.check(percepts(BAY)).holds
    assert not vacant.check(percepts(BAY, sees("sample", 1.8))).holds
    assert vacant.check(percepts(BAY, sees("sample", 1.8), closed=True, between="sample")).holds
    assert not vacant.check(percepts()).holds


def test_a_place_is_clear_when_no_robot_is_seen_at_its_approach_point() -> None:
    far_bay = sees("bay", 2.0)
    assert Clear(place="bay").check(percepts(far_bay)).holds
    assert not Clear(place="bay").check(percepts(far_bay, sees("other", 1.3))).holds
    assert Clear(place="bay").check(percepts(far_bay, sees("other", 2.5))).holds


def test_gripper_conditions_follow_the_jaws() -> None:
    full, bare = percepts(closed=True, between="sample"), percepts()
    assert Holding(object="sample").check(full).holds
    assert not Holding(object="sample").check(bare).holds
    assert Empty(open=True).check(bare).holds
    assert not Empty().check(full).holds


def test_in_view_counts_unbroken_seconds() -> None:
    with_gap = [readings(sees("other", 1))] * 20 + [readings()] * 20 + [readings(sees("other", 1))] * 20
    assert InView(target="other", for_s=2).check(percepts(sees("other", 1), for_s=2.1)).holds
    assert not InView(target="other", for_s=2).check(watch(with_gap)).holds


def test_conditions_compose() -> None:
    bare = percepts()
    assert Not(of=Holding(object="sample")).check(bare).holds
    assert AnyOf(of=(Holding(object="sample"), Empty())).check(bare).holds


def test_what_is_missing_is_reported_in_words() -> None:
    verdicts = unmet([Empty(), Holding(object="sample")], percepts())
    assert [verdict.words for verdict in verdicts] == ["holds nothing"]


@pytest.mark.parametrize(
    ("text", "sensed"),
    [
        ("in(sample, bay)", (BAY, sees("sample", 2.0))),
        ("in(sample, other)", (sees("other", 1), sees("sample", 0.7))),
        ("vacant(bay)", (BAY,)),
        ("clear(bay, hall)", (sees("bay", 2),)),
        ("near(other, bay)", (sees("bay", 2), sees("other", 1.2))),
    ],
)
def test_an_awaited_fact_is_sensed(text: str, sensed: tuple) -> None:  # type: ignore[type-arg]
    assert condition_for(fact(text), PROFILE).check(percepts(*sensed)).holds


@pytest.mark.parametrize(
    "text", ["tracked(other, me)", "in(sample, nowhere)", "robot_attribute(other, gripper, full)"]
)
def test_a_fact_no_sensor_tells_is_an_error_that_names_it(text: str) -> None:
    with pytest.raises(RepertoireError, match=text.split("(", maxsplit=1)[0]):
        condition_for(fact(text), PROFILE)
