"""Initial facts from world files."""

import pytest

from app.domain.errors import Invalid
from app.domain.world_model import initial_facts, initial_spots
from planner import Fact, KnowledgeBaseError, load_knowledge_base
from robots.world import WorldFact, WorldFile
from tests.app.sample_store import Store


@pytest.fixture
def store() -> Store:
    return Store()


def variant(store: Store, **changes: object) -> Store:
    """The sample store with something changed."""
    return Store(WorldFile.model_validate({**store.world.model_dump(), **changes}))


def moved(store: Store, robot: str, **changes: object) -> Store:
    robots = [{**spec.model_dump(), **(changes if spec.name == robot else {})} for spec in store.world.robots]
    return variant(store, robots=robots)


def test_robots_begin_near_home_with_empty_grippers(store: Store) -> None:
    for robot in store.world.robots:
        assert Fact("robot_position", (robot.name, "near", f"home_{robot.name}")) in store.facts
        assert Fact("robot_attribute", (robot.name, "gripper", "empty")) in store.facts


def test_samples_lie_where_the_file_says_and_every_other_place_that_holds_samples_is_vacant(
    store: Store,
) -> None:
    filled = {f.args[2] for f in store.facts if f.predicate == "object_position"}
    vacant = {f.args[0] for f in store.facts if f.predicate == "vacant"}
    assert filled == {"door_1", "bay_2", "bay_5", "bay_11"}
    assert vacant == {place.name for place in store.world.locations if place.capacity} - filled


def test_a_place_is_clear_in_every_area_that_reaches_it_but_where_a_robot_stands(store: Store) -> None:
    clear = {f.args for f in store.facts if f.predicate == "clear"}
    assert {("interchange_1", "yard"), ("interchange_1", "aisle_1")} <= clear
    assert ("interchange_1", "aisle_2") not in clear
    assert ("home_yard_1", "yard") not in clear


def test_robots_reach_their_own_area_and_home_only(store: Store) -> None:
    reach = {f.args[1] for f in store.facts if f.predicate == "reaches" and f.args[0] == "store_1"}
    assert reach == {*(f"bay_{n}" for n in range(1, 7)), "interchange_1", "home_store_1"}


def test_a_robot_can_do_what_its_repertoire_holds(store: Store) -> None:
    facts = moved(store, "yard_1", repertoire=("NAVIGATE",)).facts
    assert {f.args[1] for f in facts if f.predicate == "can" and f.args[0] == "yard_1"} == {"NAVIGATE"}


@pytest.mark.parametrize("changes", [{"home": None}, {"start": (4.0, 1.8, 0.0)}])
def test_a_robot_that_does_not_start_at_home_stands_at_a_spot_of_its_own(
    store: Store, changes: dict[str, object]
) -> None:
    other = moved(store, "yard_1", **changes)
    assert Fact("robot_position", ("yard_1", "near", "yard_1_spot")) in other.facts
    assert initial_spots(other.world) == {"yard_1_spot": other.world.robot("yard_1").start[:2]}


def test_the_files_extra_facts_win_over_its_layout(store: Store) -> None:
    extra = [
        {"predicate": "near", "args": ["yard_1", "door_2"]},
        {"predicate": "in", "args": ["sample_1", "yard_1"]},
    ]
    facts = variant(store, facts=extra).facts
    assert Fact("robot_position", ("yard_1", "near", "door_2")) in facts
    assert Fact("robot_position", ("yard_1", "near", "home_yard_1")) not in facts
    assert Fact("robot_attribute", ("yard_1", "gripper", "full")) in facts
    assert Fact("vacant", ("door_1",)) in facts


def test_an_extra_fact_outside_the_vocabulary_is_an_error_that_names_it(store: Store) -> None:
    world = store.world.model_copy(
        update={"facts": (WorldFact(predicate="under", args=("sample_1", "bay_1")),)}
    )
    with pytest.raises(KnowledgeBaseError, match="under"):
        initial_facts(world, store.base)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (("near", "yard_1", "door_1"), ("near", "yard_1", "door_2")),
        (("in", "sample_1", "yard_1"), ("robot_attribute", "yard_1", "gripper", "empty")),
    ],
)
def test_facts_of_a_file_that_contradict_each_other_are_refused_in_words(
    store: Store, one: tuple[str, ...], other: tuple[str, ...]
) -> None:
    facts = [WorldFact(predicate=predicate, args=tuple(args)) for predicate, *args in (one, other)]
    said = " and ".join(f"{predicate}({', '.join(args)})" for predicate, *args in (one, other))
    with pytest.raises(Invalid) as refused:
        initial_facts(store.world.model_copy(update={"facts": tuple(facts)}), load_knowledge_base())
    assert refused.value.detail == f"{said} cannot both be true"
