"""WANDER: about a cluttered room without touching anything, until its time or way is up."""

from math import dist

import numpy as np
import pytest

from benchmarks.trial import Box, Trial, packet, room
from robots.physical.body import Pose


def clutter(seed: int) -> list[Box]:
    """Boxes here and there, clear of the room's middle and with room to pass between."""
    rng = np.random.default_rng(seed)
    corners = [(1.2, 1.2), (4.4, 1.1), (1.1, 4.3), (4.5, 4.4)]
    return [(x, y, x + w, y + h) for x, y in corners for w, h in [rng.uniform(0.2, 0.6, 2)]]


@pytest.mark.parametrize("seed", range(6))
def test_wandering_runs_into_nothing_and_gets_about(seed: int) -> None:
    trial = Trial(
        room(boxes=clutter(seed), other=(1.5, 3, 0)),
        packet("WANDER", timeout_s=60),
        seed=seed,
        jitter_m=0.5,
        other=lambda t: (0.1, 0.4),
    )
    body = trial.simulation.bodies["fred"]
    touched = [False]
    ran_into: list[Pose] = []

    def watch() -> None:
        # The other drives blindly: it may run into fred, who stands or turns then, and drives off with it at his side.
        again = body.touches() and not any(touched[-40:])
        touched.append(body.touches())
        if again and body.driven[0] != 0.0:
            ran_into.append(trial.pose)

    trial.run(each=watch)
    assert ran_into == []
    assert trial.events == ["timeout"]
    assert trial.driven_m > 8
    assert max(dist((pose.x_m, pose.y_m), (3, 3)) for pose in trial.path) > 1.5


def test_wandering_can_end_by_its_way() -> None:
    trial = Trial(room(), packet("WANDER", until="toofar", max_distance_m=3)).run()
    assert trial.events == ["toofar"]
    assert trial.driven_m == pytest.approx(3, abs=0.2)


def test_the_same_seed_wanders_the_same_way() -> None:
    one, other = (
        Trial(room(boxes=clutter(1)), packet("WANDER", timeout_s=10), seed=3).run() for _ in range(2)
    )
    assert one.path == other.path
