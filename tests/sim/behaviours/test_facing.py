"""FACE_OBJECT with KeepDistance: a thing that moves is faced, and kept at its distance."""

from math import atan2, dist, sin

import pytest

from benchmarks.trial import Trial, packet, room
from robots.physical.geometry import wrap


def to_and_fro(time_s: float) -> tuple[float, float]:
    """Slowly ahead and back, in a bow."""
    return (0.2 if int(time_s / 4) % 2 == 0 else -0.2), 0.15 * sin(time_s / 3)


@pytest.mark.parametrize("seed", range(3))
def test_a_moving_thing_is_faced_and_kept_at_its_distance(seed: int) -> None:
    world = room(start=(2, 3, 180), other=(3.6, 3, 30))
    order = packet("FACE_OBJECT", object="ginger", keep_distance_m=1.2, for_s=20)
    trial = Trial(world, order, seed=seed, other=to_and_fro)
    bearings: list[float] = []
    ranges: list[float] = []

    def measure() -> None:
        me, it = trial.pose, trial.other
        bearings.append(wrap(atan2(it.y_m - me.y_m, it.x_m - me.x_m) - me.heading_rad))
        ranges.append(dist((me.x_m, me.y_m), (it.x_m, it.y_m)))

    trial.run(each=measure)
    settled = len(bearings) // 3
    assert max(map(abs, bearings[settled:])) < 0.3
    assert max(ranges[settled:]) < 1.55
    assert min(ranges[settled:]) > 0.85
    assert {"goal", "moving"} <= set(trial.events)
    assert not trial.touched


@pytest.mark.parametrize("seed", range(3))
def test_a_thing_that_gets_away_is_an_event_and_the_robot_follows(seed: int) -> None:
    """It flees at the robot's own full speed for a while, out of the distance to be kept."""
    world = room(size=(9, 6), start=(1, 3, 0), other=(2.2, 3, 0))
    order = packet("FACE_OBJECT", object="ginger", keep_distance_m=1.2, for_s=16, max_velocity_m_s=0.35)
    trial = Trial(world, order, seed=seed, other=lambda t: (0.5 if 3 < t < 10 else 0.0, 0.0)).run()
    assert [event for event in trial.events if event != "moving"][:3] == ["goal", "away", "goal"]
    assert trial.events.count("moving") == 1


@pytest.mark.parametrize("seed", range(3))
def test_without_a_distance_it_only_turns(seed: int) -> None:
    trial = Trial(room(ball=(4, 4)), packet("FACE_OBJECT", object="ball"), seed=seed, jitter_m=0.5).run()
    assert trial.driven_m < 0.02
    assert trial.events == ["goal"]
