"""What is said of a location with several berths is understood of its berths, or refused."""

import pytest

from app.domain.errors import Conflict, Invalid
from app.domain.world_model import initial_facts
from app.domain.world_model.berths import Statement, resolve_statements
from app.domain.world_model.layout import layout_of
from robots.world import load_world
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import Store

STORE = Store(berthed_store())


def understood(*statements: Statement) -> list[Statement]:
    return resolve_statements(statements, STORE.world, STORE.facts)


def test_a_sample_is_laid_in_a_free_berth_or_left_in_its_own() -> None:
    assert understood(("in", ["sample_1", "bay_2"], True)) == [("in", ("sample_1", "bay_2_2"), True)]
    assert understood(("in", ["sample_2", "bay_2"], True)) == [("in", ("sample_2", "bay_2_1"), True)]


def test_a_statement_that_lacks_an_argument_is_left_to_those_who_refuse_it() -> None:
    lacking: Statement = ("in", ["sample_1"], True)
    assert understood(lacking) == [lacking]


def test_samples_of_one_correction_get_a_berth_each() -> None:
    said = understood(
        ("in", ["sample_1", "bay_7"], True),
        ("in", ["sample_2", "bay_7_1"], True),
        ("in", ["sample_3", "bay_7"], True),
    )
    assert [args[1] for _, args, _ in said] == ["bay_7_2", "bay_7_1", "bay_7_3"]


def test_a_berth_that_the_same_correction_empties_is_free() -> None:
    said = understood(
        ("in", ["sample_2", "door_2"], True),
        ("in", ["sample_1", "bay_2"], True),
        ("in", ["sample_3", "bay_2"], True),
    )
    assert [args[1] for _, args, _ in said] == ["door_2", "bay_2_1", "bay_2_2"]


def test_without_a_free_berth_a_correction_is_refused() -> None:
    with pytest.raises(
        Conflict, match="bay_2 has no room for sample_3: none of its 2 berths is free"
    ) as refused:
        understood(("in", ["sample_1", "bay_2"], True), ("in", ["sample_3", "bay_2"], True))
    assert refused.value.code == "place-occupied"


@pytest.mark.parametrize(
    ("predicate", "args", "holds"), [("vacant", ("bay_2",), True), ("in", ("sample_2", "bay_2"), False)]
)
def test_what_holds_of_no_berth_or_of_all_is_said_of_each(
    predicate: str, args: tuple[str, ...], holds: bool
) -> None:
    said = understood((predicate, args, holds))
    assert [(berth[-1], value) for _, berth, value in said] == [("bay_2_1", holds), ("bay_2_2", holds)]


def test_where_a_robot_stands_is_said_with_the_berth() -> None:
    with pytest.raises(Invalid, match="bay_7 has 3 berths; name one") as refused:
        understood(("near", ["store_2", "bay_7"], True))
    assert refused.value.choices == ("bay_7_1", "bay_7_2", "bay_7_3")


def test_facts_of_a_world_file_may_name_the_location() -> None:
    facts = [{"predicate": "in", "args": ["sample_9", "bay_7"]}]
    samples = [{"name": "sample_9", "at": "bay_7"}, {"name": "sample_1", "at": "bay_7"}]
    world = berthed_store(samples=samples, facts=facts)
    lying = {
        f.args[0]: f.args[2] for f in initial_facts(world, STORE.base) if f.predicate == "object_position"
    }
    assert lying == {"sample_9": "bay_7_1", "sample_1": "bay_7_2"}


def test_the_layout_names_places_as_facts_do_and_racks_beside_them() -> None:
    layout = layout_of(STORE.world)
    assert {rack["name"]: rack["berths"] for rack in layout["racks"]} == {
        "bay_1": ["bay_1_1", "bay_1_2"],
        "bay_2": ["bay_2_1", "bay_2_2"],
        "bay_7": ["bay_7_1", "bay_7_2", "bay_7_3"],
    }
    names = {place["name"] for place in layout["locations"]}
    assert {fact.args[0] for fact in STORE.facts if fact.predicate == "vacant"} <= names
    assert {sample["name"]: sample["at"] for sample in layout["samples"]}["sample_2"] == "bay_2_1"


def test_the_layout_of_a_world_without_berths_is_its_file() -> None:
    world = load_world("sample_store")
    assert layout_of(world) == world.model_dump(mode="json") | {"racks": []}
