"""What befalls a robot on an errand: it recovers by itself, or says in time what it perceived; never through a wall.

`python -m benchmarks.mishaps` prints the rates over many seeds.
"""

import pytest

from benchmarks.meetings import IN_AISLE, aisle, meet
from benchmarks.mishaps.cases import cases
from benchmarks.mishaps.trial import Outcome, Trial
from benchmarks.mishaps.undertakings import PACKET_S
from robots.executive.agent import FAULT_S
from robots.executive.packet_run import LOST_S, UNSEEN_S

TICKS_S = 0.5


def befalls(name: str, *, seed: int = 1) -> Outcome:
    """What becomes of the errand; in no case may the robot be in a wall, or call done what is not."""
    (case,) = [case for case in cases() if str(case) == name]
    outcome = Trial(case, seed).run()
    assert outcome.took_s is not None, "nothing befell"
    assert not outcome.walled
    assert outcome.how not in ("wrong", "silent"), outcome
    return outcome


@pytest.mark.parametrize("case", ["carried off, DOCK", "pushed, RELEASE2", "turned by hand, TRANSPORT"])
def test_a_robot_that_is_moved_by_hand_finds_out_where_it_is_and_goes_on(case: str) -> None:
    assert befalls(case).how == "recovered"


def test_what_is_hidden_for_a_while_is_waited_for() -> None:
    assert befalls("all covered 10 s, RELEASE2").how == "recovered"


def test_a_robot_that_is_blinded_as_it_backs_off_does_not_cross_the_yard_backwards() -> None:
    outcome = befalls("infra-red covered, RELEASE2")
    assert outcome.how == "reported"
    assert "no beacon in view at all" in outcome.words
    assert outcome.end is not None
    assert 2.0 < outcome.end.y_m < 2.9


def test_a_deposit_whose_beacon_stays_hidden_is_given_up() -> None:
    outcome = befalls("beacon hidden for good, TRANSPORT")
    assert outcome.how == "reported"
    assert outcome.took_s is not None
    assert outcome.took_s < PACKET_S + UNSEEN_S
    assert "for want of sight: the robot does not see the beacon of interchange_2" in outcome.words
    assert "interchange_2 not seen for" in outcome.words


def test_a_sample_that_is_knocked_away_from_the_jaws_is_fetched_where_it_lies() -> None:
    assert befalls("sample knocked 0.15 m, DOCK").how == "recovered"


def test_a_sample_that_is_knocked_out_of_the_jaws_is_reported_with_where_it_is_seen() -> None:
    outcome = befalls("sample knocked from jaws, TRANSPORT")
    assert outcome.how == "reported"
    assert outcome.took_s is not None
    assert outcome.took_s <= LOST_S + TICKS_S
    assert "holds nothing" in outcome.words
    assert "sees sample_1" in outcome.words


def test_a_blocked_interchange_is_reported_with_what_is_in_the_way() -> None:
    outcome = befalls("box at the approach point, TRANSPORT")
    assert outcome.how == "reported"
    assert outcome.took_s is not None
    assert outcome.took_s <= PACKET_S + TICKS_S
    assert "something" in outcome.words
    assert "from its hull" in outcome.words


@pytest.mark.parametrize("robot", ["fred", "ginger"])
def test_who_carries_together_waits_for_a_partner_that_sees_nothing_for_a_while(robot: str) -> None:
    assert befalls(f"all covered 10 s, TRANSPORT of {robot}").how == "recovered"


def test_who_backs_off_by_odometry_that_stands_still_sees_when_it_is_far_enough() -> None:
    assert befalls("odometry frozen, TRANSPORT of fred").how == "recovered"


def test_a_robot_goes_on_without_a_whisker_that_is_stuck() -> None:
    assert befalls("one whisker reads 0, TRANSPORT").how == "recovered"


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("infra-red frozen", "the beacon sensor reads the same"),
        ("odometry NaN", "odometry reads"),
    ],
)
def test_a_sensor_that_cannot_be_spared_is_given_up_by_name(fault: str, words: str) -> None:
    outcome = befalls(f"{fault}, TRANSPORT")
    assert outcome.how == "reported"
    assert outcome.took_s is not None
    assert outcome.took_s <= 2 * FAULT_S
    assert words in outcome.words


def test_a_sensor_that_comes_back_in_time_is_ridden_out() -> None:
    assert befalls("infra-red NaN 3 s, RELEASE2").how == "recovered"


def test_robots_that_meet_head_on_in_an_aisle_pass_each_other() -> None:
    arrived, _, words = meet(aisle(1.6), IN_AISLE, 0, 40.0)
    assert arrived, words


def test_robots_that_cannot_pass_each_other_say_whom_they_met() -> None:
    arrived, took_s, words = meet(aisle(1.0), IN_AISLE, 0, 20.0)
    assert not arrived
    assert took_s <= 20 + 1
    assert any("sees ginger" in said or "sees fred" in said for said in words)
