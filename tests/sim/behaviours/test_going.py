"""STEP and MOVE_TO: by the way asked, to the place asked, round what is in the way."""

from math import cos, dist, sin

import pytest

from benchmarks.trial import Trial, packet, room
from robots.wire import ScriptState

BOX = (2.6, 2.4, 3.4, 3.6)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("distance", [0.3, -0.5, 1.2])
def test_a_step_is_as_long_as_asked_and_straight(distance: float, seed: int) -> None:
    trial = Trial(room(), packet("STEP", distance_m=distance), seed=seed, jitter_m=0.5)
    begun = trial.pose
    trial.run()
    ahead = (trial.pose.x_m - begun.x_m) * cos(begun.heading_rad)
    ahead += (trial.pose.y_m - begun.y_m) * sin(begun.heading_rad)
    assert ahead == pytest.approx(distance, abs=0.04 + 0.05 * abs(distance))
    assert dist((trial.pose.x_m, trial.pose.y_m), (begun.x_m, begun.y_m)) == pytest.approx(
        abs(ahead), abs=0.01
    )
    assert trial.events == ["goal"]


@pytest.mark.parametrize("seed", range(3))
def test_a_step_into_a_wall_stops_before_it_and_fails(seed: int) -> None:
    trial = Trial(room(start=(4.8, 3, 0)), packet("STEP", distance_m=3), seed=seed).run()
    assert trial.ended is not None
    assert trial.ended.state is ScriptState.FAILED
    assert "no progress" in trial.ended.detail
    assert not trial.touched


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("avoid", ["patterns", "vfh_plus", "dynamic_window"])
def test_move_to_a_point_behind_a_box(avoid: str, seed: int) -> None:
    world = room(start=(1, 3, 0), boxes=[BOX])
    trial = Trial(world, packet("MOVE_TO", x=5, y=3, avoid=avoid), seed=seed, jitter_m=0.5).run()
    assert trial.events == ["goal"]
    assert dist((trial.pose.x_m, trial.pose.y_m), (5, 3)) < 0.35


@pytest.mark.parametrize("seed", range(3))
def test_move_to_an_object_stops_before_it(seed: int) -> None:
    trial = Trial(
        room(start=(1, 3, 0), ball=(4, 4)), packet("MOVE_TO", object="ball"), seed=seed, jitter_m=0.5
    )
    trial.run()
    ball = trial.simulation.truth().samples["ball"]
    assert trial.events == ["close", "goal"]
    assert 0.5 < dist((trial.pose.x_m, trial.pose.y_m), (ball.x_m, ball.y_m)) < 0.85
    assert dist((ball.x_m, ball.y_m), (4, 4)) < 0.05
    assert not trial.touched
