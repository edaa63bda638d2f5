from pathlib import Path

import pytest

from planner import KnowledgeBaseError, load_knowledge_base, merge_knowledge_bases, shipped_knowledge_base

INSPECTION = """\
types:
  attribute: {values: [camera]}
predicates:
  inspected:
    arguments: {location: location}
    phrase: "{location} was inspected"
    denial: "{location} was not inspected"
actions:
  - identifier: 1
    name: INSPECT
    parameters:
      - {name: robot, type: robot}
      - {name: ref, type: location}
    agents: [robot]
    preconditions:
      - robot_position(robot, near, ref)
      - can(robot, INSPECT)
    delete: []
    intended_effects: ["inspected(ref)"]
    other_effects: []
    duration: 4
    description: "{robot} inspect {ref}"
"""


def file(folder: Path, text: str, name: str = "inspection.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def refusal(*paths: Path) -> str:
    with pytest.raises(KnowledgeBaseError) as refused:
        merge_knowledge_bases(paths)
    return str(refused.value)


def test_a_file_adds_actions_predicates_and_constants_to_those_it_rests_on(tmp_path: Path) -> None:
    base = merge_knowledge_bases([shipped_knowledge_base(), file(tmp_path, INSPECTION)])
    assert set(base.actions) == {*load_knowledge_base().actions, "INSPECT"}
    assert "inspected" in base.predicates
    assert base.file.constants("attribute") == ("gripper", "camera")
    assert base.constants["INSPECT"] == "tag"


def test_actions_of_several_files_get_different_numbers(tmp_path: Path) -> None:
    base = merge_knowledge_bases([shipped_knowledge_base(), file(tmp_path, INSPECTION)])
    numbers = [action.identifier for action in base.file.actions]
    assert len(set(numbers)) == len(load_knowledge_base().actions) + 1
    assert len(set(numbers)) == len(numbers)


def test_what_is_the_same_in_two_files_is_taken_once(tmp_path: Path) -> None:
    added = file(tmp_path, INSPECTION)
    again = file(tmp_path, INSPECTION, "again.yaml")
    twice = merge_knowledge_bases([shipped_knowledge_base(), added, again])
    assert twice.file == merge_knowledge_bases([shipped_knowledge_base(), added]).file


def test_one_file_alone_is_the_knowledge_base_that_it_holds() -> None:
    assert merge_knowledge_bases([shipped_knowledge_base()]).file == load_knowledge_base().file


@pytest.mark.parametrize(
    ("right", "wrong", "line", "slot"),
    [
        ("duration: 4", "duration: 5", 9, "INSPECT is defined differently"),
        ("arguments: {location: location}", "arguments: {location: robot}", 5, "predicates.inspected"),
        ("attribute: {values: [camera]}", "attribute: {parent: thing}", 2, "types.attribute"),
    ],
)
def test_a_name_with_two_meanings_is_refused_naming_both_files_and_lines(
    tmp_path: Path, right: str, wrong: str, line: int, slot: str
) -> None:
    first = file(tmp_path, INSPECTION, "first.yaml")
    second = file(tmp_path, INSPECTION.replace(right, wrong), "second.yaml")
    said = refusal(shipped_knowledge_base(), first, second)
    assert said.startswith(f"{second} is not a valid knowledge base:")
    assert f"line {line}, " in said
    assert slot in said
    assert f"first in {first if 'attribute' not in right else shipped_knowledge_base()}, line " in said


def test_an_action_twice_in_one_file_is_refused(tmp_path: Path) -> None:
    action = INSPECTION.partition("actions:\n")[2]
    said = refusal(shipped_knowledge_base(), file(tmp_path, INSPECTION + action))
    assert "line 23, INSPECT, name: INSPECT is defined twice, first in" in said


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("near, ref)", "beside, ref)", ["line 16, INSPECT, preconditions.0", "beside", "near"]),
        (
            "inspected(ref)",
            "inspectd(ref)",
            ["line 19, INSPECT, intended_effects.0", "inspectd", "inspected"],
        ),
        (
            "{location: location}",
            "{location: place}",
            ["line 5", "predicates.inspected", "place", "location"],
        ),
        ("duration: 4", "durations: 4", ["line 21, INSPECT", "durations", "there is no such slot"]),
    ],
)
def test_what_does_not_fit_the_other_files_is_named_with_file_line_slot_and_choices(
    tmp_path: Path, right: str, wrong: str, words: list[str]
) -> None:
    path = file(tmp_path, INSPECTION.replace(right, wrong))
    said = refusal(shipped_knowledge_base(), path)
    assert f"{path} is not a valid knowledge base:" in said
    assert [word for word in words if word not in said] == [], said


@pytest.mark.parametrize("text", ["[]", "a: [", "a: 1\na: 2", "actions: {}", "\x00"])
def test_a_file_that_is_none_is_refused_by_its_name(tmp_path: Path, text: str) -> None:
    path = file(tmp_path, text)
    assert str(path) in refusal(shipped_knowledge_base(), path)


def test_a_missing_file_is_refused_by_its_name(tmp_path: Path) -> None:
    assert "nowhere.yaml" in refusal(shipped_knowledge_base(), tmp_path / "nowhere.yaml")
