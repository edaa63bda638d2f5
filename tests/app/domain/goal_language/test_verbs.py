"""Verbs as data: checked, merged, and enough to give a new command a meaning."""

from pathlib import Path

import pytest

from app.domain.goal_language.grammar import Clarification, parse_goal
from app.domain.goal_language.verbs import Verbs, VerbsError, load_verbs, shipped_verbs
from tests.app.berthed_store import berthed_store
from tests.app.sample_store import Store

STORE = Store()
INSPECT = """
verbs:
  - name: inspect
    words: [inspect, survey]
    slots:
      place: {kind: place, role: object}
    goals: ["inspected(?place)"]
"""


def verbs_of(folder: Path, text: str, name: str = "verbs.yaml") -> Verbs:
    (folder / name).write_text(text)
    return load_verbs(folder / name)


def stated(text: str, verbs: Verbs) -> list[str]:
    parsed = parse_goal(text, STORE.world, STORE.facts, verbs)
    assert not isinstance(parsed, Clarification), parsed
    return [str(goal) for goal in parsed]


def test_the_shipped_verbs_are_about_relations_of_the_shipped_knowledge_base() -> None:
    shipped_verbs().check_predicates(STORE.base.relation_names())
    assert {"move", "swap", "send", "park"} <= set(shipped_verbs().words)


def test_a_verb_of_a_pack_is_understood_beside_the_others(tmp_path: Path) -> None:
    verbs = shipped_verbs().merged(verbs_of(tmp_path, INSPECT))
    assert stated("inspect bay_4 and move sample_1 to bay_7", verbs) == [
        "inspected(bay_4)",
        "in(sample_1, bay_7)",
    ]
    doors = stated("survey all doors", verbs)
    assert doors == ["inspected(door_1)", "inspected(door_2)"]
    assert stated("inspect all bays of aisle_2", verbs)[0] == "inspected(bay_7)"


def test_a_location_with_berths_is_inspected_at_each(tmp_path: Path) -> None:
    racks = Store(berthed_store())
    parsed = parse_goal("inspect bay_2", racks.world, racks.facts, verbs_of(tmp_path, INSPECT))
    assert not isinstance(parsed, Clarification)
    assert [str(goal) for goal in parsed] == ["inspected(bay_2_1)", "inspected(bay_2_2)"]


def test_a_place_to_inspect_is_asked_for(tmp_path: Path) -> None:
    verbs = shipped_verbs().merged(verbs_of(tmp_path, INSPECT))
    asked = parse_goal("inspect", STORE.world, STORE.facts, verbs)
    assert isinstance(asked, Clarification)
    assert (asked.code, asked.choices[0], asked.span) == ("place-needed", "bay_1", (7, 7))


def test_without_the_pack_the_verb_is_unknown() -> None:
    asked = parse_goal("inspect bay_4", STORE.world, STORE.facts)
    assert isinstance(asked, Clarification)
    assert (asked.code, asked.thing, asked.span) == ("unknown-verb", "inspect", (0, 7))
    assert asked.choices == shipped_verbs().words


def test_a_word_with_two_meanings_is_refused_with_both_files(tmp_path: Path) -> None:
    other = verbs_of(tmp_path, INSPECT.replace("survey", "move"), "other.yaml")
    with pytest.raises(VerbsError, match=r"'move' is stated by verbs\.yaml \(move\) and by .*other\.yaml"):
        shipped_verbs().merged(other)


def test_the_same_verb_twice_is_one(tmp_path: Path) -> None:
    one = verbs_of(tmp_path, INSPECT, "one.yaml")
    other = verbs_of(tmp_path, INSPECT, "other.yaml")
    assert one.merged(other).words == ("inspect", "survey")


@pytest.mark.parametrize(
    ("wrong", "right", "told"),
    [
        ("inspected(?place)", "inspected(?spot)", "verbs.0: goals.0: no slot 'spot'"),
        ("inspected(?place)", "inspected", "verbs.0.goals: 'inspected' is not of the form"),
        (
            "kind: place",
            "kind: planet",
            "verbs.0.slots.place.kind: Input should be 'sample', 'robot' or 'place'",
        ),
        ("role: object", "role: target", "one slot must be the object"),
        ("role: object", "role: object, default: nearest(?place)", "unknown function 'nearest'; choices:"),
        ("role: object", "role: object, default: place_of(?place)", "place_of takes a slot of kind sample"),
        ("goals:", "gaols:", "verbs.0.goals: Field required"),
        ("[inspect, survey]", "[inspect, inspect]", "the word 'inspect' is of both"),
        ("verbs:", "verbs: [", "line"),
    ],
)
def test_a_wrong_file_is_refused_with_the_file_and_the_slot(
    tmp_path: Path, wrong: str, right: str, told: str
) -> None:
    with pytest.raises(VerbsError) as refused:
        verbs_of(tmp_path, INSPECT.replace(wrong, right))
    assert str(tmp_path) in str(refused.value)
    assert told in str(refused.value)


def test_a_goal_about_no_relation_is_refused_with_the_choices(tmp_path: Path) -> None:
    verbs = verbs_of(tmp_path, INSPECT)
    with pytest.raises(
        VerbsError, match=r"inspect\.goals\.0: unknown predicate 'inspected'; choices: .*near"
    ):
        verbs.check_predicates(STORE.base.relation_names())


JOIN = """
verbs:
  - name: join
    words: [join]
    slots:
      robot: {kind: robot, role: object}
    given:
      area: known(in_area, yard_2)
      same: known(in_area, ?robot)
    goals: ["in_area(?robot, ?area)", "in_area(yard_2, ?same)"]
"""


def test_a_value_may_be_what_a_known_fact_says(tmp_path: Path) -> None:
    assert stated("join store_1", verbs_of(tmp_path, JOIN)) == [
        "in_area(store_1, yard)",
        "in_area(yard_2, aisle_1)",
    ]
    asked = parse_goal("join store_1", STORE.world, frozenset(), verbs_of(tmp_path, JOIN))
    assert isinstance(asked, Clarification)
    assert (asked.code, asked.detail) == (
        "fact-needed",
        "no fact 'in_area' of yard_2 is known in sample_store",
    )


def test_a_place_after_at_is_the_object_of_a_verb_about_places_alone(tmp_path: Path) -> None:
    verbs = verbs_of(tmp_path, INSPECT)
    assert stated("inspect at bay_4 and bay_5", verbs) == ["inspected(bay_4)", "inspected(bay_5)"]


@pytest.mark.parametrize(
    ("new", "words"),
    [
        ("known(?robot)", "given.area: known takes a predicate first"),
        ("known(in_area, ?same)", "given.area: no slot '?same' for known(in_area, ?same); choices: ?robot"),
        ("known(inarea, yard_2)", "join.given.area: unknown predicate 'inarea'; choices: "),
    ],
)
def test_what_is_known_is_checked(tmp_path: Path, new: str, words: str) -> None:
    with pytest.raises(VerbsError) as refused:
        verbs_of(tmp_path, JOIN.replace("known(in_area, yard_2)", new)).check_predicates(
            STORE.base.relation_names()
        )
    assert words in str(refused.value.detail)
