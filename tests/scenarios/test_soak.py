"""A short soak: random goals and a fault on a service of its own; afterwards all must hold. `macta soak` is longer."""

import pytest

from app.cli.soak import SoakRequest, soak
from robots.world import load_world

SEED = 139
"""By this one the first fault comes after 2.0 s, and is that the simulation is killed."""


def test_a_few_seconds_of_goals_and_a_fault_leave_nothing_undone_and_nothing_untrue(
    capsys: pytest.CaptureFixture[str],
) -> None:
    ended = soak(SoakRequest(world=load_world("sample_store"), minutes=0.06, seed=SEED, speed=40.0))
    said = capsys.readouterr().out
    assert ended == 0, said
    assert "goals taken" in said
    assert "simulation killed" in said
    assert "all checks passed" in said
