"""Sentences name zones as they name aisles and compartments."""

import pytest

from app.domain.goal_language.completion import completions
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.world_model import initial_facts
from app.packs.find import load_packs
from robots.world import WorldFile, load_world
from tests.app.sample_store import Store

ZONES = (
    {"name": "north_field", "x": (0, 8), "y": (6, 9)},
    {"name": "spill", "x": (0, 1), "y": (5, 6), "rule": "keep_out"},
)
STORE = Store(WorldFile.model_validate({**load_world("sample_store").model_dump(), "zones": ZONES}))


def read(text: str) -> Understood:
    understood = understand(text, STORE.world, STORE.facts)
    assert isinstance(understood, Understood), understood
    return understood


def asked(text: str) -> Clarification:
    question = understand(text, STORE.world, STORE.facts)
    assert isinstance(question, Clarification), question
    return question


def test_every_sample_of_a_zone_is_those_that_lie_there() -> None:
    understood = read("bring every sample of north_field to door_2")
    assert [str(goal) for goal in understood.goals] == [
        f"in(sample_{number}, door_2)" for number in (2, 3, 4)
    ]
    assert [one.means for one in understood.readings] == [("sample_2", "sample_3", "sample_4")]


def test_any_place_of_a_zone_is_one_inside_that_is_free() -> None:
    (goal,) = read("move sample_1 to any bay of north_field").goals
    assert goal.args == ("sample_1", "bay_3")


def test_not_through_a_zone_avoids_its_places() -> None:
    avoided = read("move sample_1 to any bay, not through North Field").constraints.avoid
    assert set(avoided) == {
        *(f"bay_{number}" for number in (2, 3, 5, 6, 8, 9, 11, 12)),
        "home_store_1",
        "home_store_2",
    }


def test_a_zone_is_no_place_but_has_some() -> None:
    question = asked("move sample_1 to north_field")
    assert (question.code, question.choices[0]) == ("unknown-place", "any place of north_field")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("bring every sample of nor", "bring every sample of north_field"),
        ("move sample_1 to bay_7 avoiding nor", "move sample_1 to bay_7 avoiding north_field"),
        ("move sample_1 to bay_7 avoiding ai", "move sample_1 to bay_7 avoiding aisle_1"),
    ],
)
def test_names_of_zones_are_completed(text: str, sentence: str) -> None:
    assert sentence in completions(text, asked(text), STORE.world, STORE.facts)


def test_every_place_of_a_zone_is_inspected() -> None:
    packs = load_packs(["survey"])
    file = load_world("survey_site", worlds=packs.worlds())
    zones = [{"name": "west", "x": (5, 12), "y": (0, 15)}]
    world = WorldFile.model_validate({**file.model_dump(), "zones": zones})
    facts = initial_facts(world, packs.knowledge_base())
    understood = understand("inspect every place of west", world, facts, verbs=packs.verbs())
    assert isinstance(understood, Understood), understood
    inside = {place.name for place in world.places if 5 <= place.at[0] <= 12}
    assert len(inside) > 1
    assert {goal.args[-1] for goal in understood.goals} == inside
