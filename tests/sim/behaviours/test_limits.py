"""MaxVelocity, MaxDistance and Timeout: what every packet keeps to, and the events that tell of it."""

from itertools import pairwise
from math import dist

import pytest

from benchmarks.trial import Trial, packet, room
from robots.wire import FailureCategory, ScriptState


@pytest.mark.parametrize("seed", range(3))
def test_no_packet_drives_faster_than_its_limit(seed: int) -> None:
    trial = Trial(room(), packet("STEP", distance_m=1, max_velocity_m_s=0.2), seed=seed).run()
    speeds = [dist((one.x_m, one.y_m), (other.x_m, other.y_m)) * 20 for one, other in pairwise(trial.path)]
    assert max(speeds) == pytest.approx(0.2, abs=0.01)
    assert trial.events == ["goal"]


def test_a_robot_that_comes_in_too_fast_says_so() -> None:
    """The first packet is broken off at speed by its distance; the next allows a quarter of that speed."""
    fast = packet("WANDER", until="toofar", max_distance_m=1.5)
    slow = packet("STEP", distance_m=0.6, max_velocity_m_s=0.1)
    trial = Trial(room(), fast, slow).run()
    assert trial.events == ["toofar", "toofast", "goal"]


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_that_drives_too_far_breaks_off_and_says_so(seed: int) -> None:
    trial = Trial(room(), packet("MOVE_TO", x=5, y=5, max_distance_m=1), seed=seed, jitter_m=0.5).run()
    assert trial.ended is not None
    assert (trial.ended.state, trial.ended.category) == (ScriptState.FAILED, FailureCategory.ROBOT)
    assert trial.events == ["toofar"]
    assert "toofar" in trial.ended.detail
    assert trial.driven_m == pytest.approx(1, abs=0.1)


def test_a_packet_that_takes_too_long_breaks_off_and_says_so() -> None:
    trial = Trial(room(), packet("FOLLOW_LEFT_OBSTACLE", until="opening", timeout_s=4)).run()
    assert trial.ended is not None
    assert (trial.ended.state, trial.ended.category) == (ScriptState.FAILED, FailureCategory.DEADLINE)
    assert trial.events == ["timeout"]


def test_events_come_with_the_report_of_the_packets_end() -> None:
    trial = Trial(room(), packet("TURN_LEFT")).run()
    assert [report.state.value for report in trial.reports] == ["initializing", "running", "finished"]
    assert trial.reports[-1].events == ("turned",)
    assert "has turned by" in trial.reports[-1].detail
