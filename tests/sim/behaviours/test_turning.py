"""STOP, TURN_LEFT, TURN_RIGHT, TURN_TO, TURN_TOWARD: on the spot, by the angle asked."""

from math import atan2, pi, radians

import pytest

from benchmarks.trial import Trial, packet, room
from robots.geometry import wrap
from robots.wire import ScriptState

ODOMETRY = 0.05
"""Share of the angle by which a seed's odometry may be wrong: five times its scale error."""
WITHIN_RAD = 0.06


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("tag", "sign"), [("TURN_LEFT", 1), ("TURN_RIGHT", -1)])
@pytest.mark.parametrize("angle", [0.3, pi / 2, 3 * pi])
def test_a_turn_is_by_the_angle_asked_to_the_side_asked(tag: str, sign: int, angle: float, seed: int) -> None:
    trial = Trial(room(), packet(tag, angle_rad=angle), seed=seed, jitter_m=1.0)
    begun, turned = trial.pose.heading_rad, [0.0]

    def add() -> None:
        turned.append(turned[-1] + wrap(trial.pose.heading_rad - begun - turned[-1]))

    trial.run(each=add)
    assert sign * turned[-1] == pytest.approx(angle, abs=WITHIN_RAD + ODOMETRY * angle)
    assert trial.driven_m < 0.02
    assert trial.events == ["turned"]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("angle", [-2.5, 0.0, pi])
def test_turn_to_ends_at_the_heading_asked(angle: float, seed: int) -> None:
    trial = Trial(room(), packet("TURN_TO", angle_rad=angle), seed=seed, jitter_m=1.0).run()
    assert wrap(trial.pose.heading_rad - angle) == pytest.approx(
        0, abs=0.15
    )  # told its start within 2 degrees
    assert trial.events == ["turned"]


@pytest.mark.parametrize("seed", range(3))
def test_turn_toward_a_point_and_toward_an_object(seed: int) -> None:
    aims = ({"x": 1, "y": 5}, {"object": "ball"})
    for aim, (x, y) in zip(aims, ((1, 5), (4.5, 2)), strict=True):
        trial = Trial(room(ball=(4.5, 2)), packet("TURN_TOWARD", **aim), seed=seed, jitter_m=0.5).run()
        towards = atan2(y - trial.pose.y_m, x - trial.pose.x_m)
        assert wrap(trial.pose.heading_rad - towards) == pytest.approx(0, abs=radians(9))
        assert trial.events == ["turned"]


@pytest.mark.parametrize("seed", range(3))
def test_stop_ends_at_rest(seed: int) -> None:
    hurry = packet("STEP", distance_m=2, max_distance_m=5)
    trial = Trial(room(), hurry, packet("STOP"), seed=seed)
    trial.run()
    stood = trial.pose
    trial.run_for(1.0)
    assert trial.ended is not None
    assert trial.ended.state is ScriptState.FINISHED
    assert (trial.pose.x_m, trial.pose.y_m) == pytest.approx((stood.x_m, stood.y_m), abs=0.01)
