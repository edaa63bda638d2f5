"""Goals drawn by chance are goals that the world can take."""

import pytest

from app.domain.errors import Invalid
from app.domain.goal_language.check import check_goals
from app.trials.random_goals import drawn_goals
from tests.app.sample_store import Store

STORE = Store()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_drawn_goals_are_possible_and_not_yet_true(count: int) -> None:
    for seed in range(20):
        goals = drawn_goals(STORE.world, STORE.facts, count, seed, STORE.base)
        assert len({goal.args[0] for goal in goals}) == count
        assert not check_goals(goals, STORE.world, STORE.facts, STORE.base)
        assert all(STORE.world.location(goal.args[1]).kind in ("bay", "door") for goal in goals)


def test_a_seed_draws_the_same_goals_and_another_seed_others() -> None:
    drawn = [drawn_goals(STORE.world, STORE.facts, 2, seed, STORE.base) for seed in (0, 0, 1)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_more_goals_than_samples_are_refused_with_their_number() -> None:
    with pytest.raises(Invalid, match="no 5 goals at once that sample_store can take: it has 4 samples"):
        drawn_goals(STORE.world, STORE.facts, 5, 0, STORE.base)
