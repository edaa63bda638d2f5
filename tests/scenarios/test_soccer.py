"""Robot soccer (SRA, fig. 5): a ball is tracked and kicked, roles change on request, and all go home on request."""

import pytest

from benchmarks.demonstrations.soccer import ALL, GOALS, Match, Referee, note_goal, play, roles
from benchmarks.demonstrations.stage import Stage

ROLES = {"alice": ("attacker",), "bob": ("left_defender",), "carl": ("opponent",)}


@pytest.mark.parametrize(("seed", "loss"), [(0, 0.0), (1, 0.3)])
def test_goals_fall_partners_change_roles_and_all_go_home(seed: int, loss: float) -> None:
    match = play(seed, loss)
    assert match.succeeded, match
    assert match.scored >= 1
    assert len(match.reset_s) == GOALS


def test_after_a_goal_against_them_all_go_home_in_the_roles_that_they_have() -> None:
    with Stage("soccer", seed=0) as stage:
        referee = Referee(stage)

        def play_on() -> bool:
            return all(stage.is_believed(name, "playing") for name in ALL)

        assert stage.run_until(play_on, timeout_s=10.0)
        assert roles(stage) == ROLES
        referee.lay(-4.5 + 0.3j)
        assert stage.run_until(lambda: referee.is_goal, timeout_s=10.0)
        assert referee.crossed == -1
        match = Match(seed=0)
        assert note_goal(stage, match, ROLES, is_ours=False) == ROLES
        assert (match.conceded, match.resets, match.changes) == (1, 1, 0)
        referee.kick_off()
        assert stage.run_until(play_on, timeout_s=10.0)
