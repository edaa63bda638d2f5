"""A short soak: random goals and faults on a service of its own; afterwards all must hold."""

import pytest

from app.cli.soak import SoakRequest, soak
from robots.world import load_world


@pytest.mark.timeout(900)
def test_half_a_minute_of_goals_and_faults_leaves_nothing_undone_and_nothing_untrue(
    capsys: pytest.CaptureFixture[str],
) -> None:
    ended = soak(SoakRequest(world=load_world("sample_store"), minutes=0.5, seed=4, speed=6.0))
    said = capsys.readouterr().out
    assert ended == 0, said
    assert "goals taken" in said
    assert "all checks passed" in said
