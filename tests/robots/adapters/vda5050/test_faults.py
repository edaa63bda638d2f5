"""Lost, repeated, delayed messages, outages and restarts: nothing is done twice, nothing is lost.

`python -m benchmarks.vda5050` does the same with 200 seeds.
"""

import pytest

from benchmarks.vda5050.__main__ import CONDITIONS
from benchmarks.vda5050.faults import Run

SEEDS = range(20)


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_done_twice_and_nothing_is_lost(seed: int) -> None:
    result = Run(seed, CONDITIONS["all of these"])()
    assert result.faults == ()
    assert result.failed == ()


def test_the_runs_have_restarts_and_would_notice_a_deed_done_twice() -> None:
    run = Run(0, CONDITIONS["a restart every 5 s"])
    result = run()
    assert result.restarts > 0
    assert result.faults == ()
    run.vehicle.deeds["macta.s1.1:b:0"] += 1
    assert "s1/b was done 2 times" in list(run.wrong())
