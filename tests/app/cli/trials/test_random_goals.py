"""Goals drawn by chance are goals that the world can take."""

import random

import pytest

from app.cli.trials.random_goals import drawn_goals, drawn_sentence
from app.domain.errors import Invalid
from app.domain.goal_language.check import check_goals
from app.domain.goal_language.grammar import Understood, understand
from app.domain.goal_language.verbs import Verbs, shipped_verbs
from benchmarks.sentence_fuzz import NOW
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


def test_sentences_are_of_every_verb_that_is_about_what_the_world_has() -> None:
    verbs = shipped_verbs()
    chance = random.Random(0)
    drawn = [drawn_sentence(STORE.world, verbs, chance) for _ in range(200)]
    assert {text.split()[0] for text in drawn} == set(verbs.words)
    bare = STORE.world.model_copy(update={"samples": ()})
    of_robots = {"send", "drive", "park", "charge", "recharge"}
    assert {drawn_sentence(bare, verbs, chance).split()[0] for _ in range(50)} == of_robots
    understood = [understand(text, STORE.world, STORE.facts, verbs=verbs, now=NOW) for text in drawn]
    assert sum(isinstance(one, Understood) for one in understood) > 150


def test_verbs_about_what_a_world_lacks_are_no_goals() -> None:
    moving = Verbs({"move": shipped_verbs().by_word["move"]}, {})
    with pytest.raises(Invalid, match="no verb of the packs is about what sample_store has: move"):
        drawn_sentence(STORE.world.model_copy(update={"samples": ()}), moving, random.Random(0))
