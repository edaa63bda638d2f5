"""The mixed waltz (SRA, fig. 8): a robot on wheels and a virtual one, in step by messages of their rules alone."""

import pytest

from benchmarks.demonstrations.stage import Stage
from benchmarks.demonstrations.waltz import FIGURES, FOLLOW, LEAD, dance


def test_both_dance_three_rounds_in_step_round_the_rocks() -> None:
    waltz = dance(0, 0.0)
    assert (waltz.figures, waltz.bowed, waltz.touches) == (FIGURES, True, 0)
    assert len(waltz.late_s) == FIGURES
    assert max(waltz.late_s) < 0.5
    assert waltz.closed_m < 0.4
    assert waltz.apart_m < 0.6
    assert waltz.nearest_m > 0.5


@pytest.mark.parametrize("seed", [1, 2])
def test_lost_messages_delay_figures_and_neither_robot_dances_one_alone(seed: int) -> None:
    waltz = dance(seed, 0.3)
    assert waltz.succeeded, waltz
    assert max(waltz.late_s) > 1.0
    assert waltz.apart_at_most_m < 2.5


def test_nobody_dances_without_messages() -> None:
    with Stage("waltz", seed=0, loss=1.0) as stage:
        begun = stage.places()
        stage.run_until(lambda: False, timeout_s=10.0)
        moved = {name: abs(place - begun[name]) for name, place in stage.places().items()}
        assert stage.simulation.hub.peer_letters > 1
        assert max(moved.values()) < 0.01, moved
        assert {name: stage.is_believed(name, "danced") for name in (LEAD, FOLLOW)} == {
            LEAD: False,
            FOLLOW: False,
        }


def test_the_dance_goes_on_where_it_was_after_a_power_failure() -> None:
    with Stage("waltz", seed=0) as stage:

        def have_danced(robot: str, step: str) -> bool:
            return f"danced(1, {step})" in map(str, stage.beliefs(robot))

        assert stage.run_until(lambda: have_danced(LEAD, "side"), timeout_s=60.0)
        stage.restart()
        believed: set[str] = set()
        stage.watch = lambda: believed.update(map(str, stage.beliefs(LEAD)))
        stage.run_until(lambda: False, timeout_s=1.0)
        stage.watch = lambda: None
        assert "figure(1, position)" not in believed
        assert stage.run_until(lambda: have_danced(LEAD, "back"), timeout_s=120.0)
        assert have_danced(FOLLOW, "back")
