"""What `macta pack check` finds, and where."""

from pathlib import Path

import pytest

from app.packs.check import faults_of
from app.packs.contents import contents_of
from app.packs.errors import PackError
from app.packs.find import find_pack, load_packs
from app.packs.scaffold import write_example
from tests.app.packs.pack_folders import change, example

BASE = "knowledge_base.yaml"
LIBRARY = "behaviours_library.yaml"
PACKET = "repertoire/observe.yaml"
WORLD = "worlds/looks_yard.yaml"


def test_the_new_pack_is_valid(tmp_path: Path) -> None:
    assert list(faults_of(load_packs([str(example(tmp_path))]))) == []


def test_what_ships_is_valid() -> None:
    assert list(faults_of(load_packs(["store"]))) == []


@pytest.mark.parametrize(
    ("file", "right", "wrong", "words"),
    [
        (BASE, "near]", "beside]", ["line 14, OBSERVE", "parameters.1.values", "beside", "near"]),
        (BASE, "observed(ref)", "seen(ref)", ["line 24, OBSERVE, intended_effects.0", "seen", "observed"]),
        (LIBRARY, "observed(?ref)", "seen(?ref)", ["line 8, packets.0.achieves.0", "seen", "observed"]),
        (LIBRARY, "tag: OBSERVE", "tag: OBSRVE", ["line 3, packets.0.tag", "OBSERVE", "NAVIGATE"]),
        (PACKET, "sense: facing", "sense: fcing", ["line 22, after.0", "fcing", "facing"]),
        (PACKET, "$for_s", "$for", ["line 23, after.1", "$for", "for_s"]),
        (
            WORLD,
            "OBSERVE]",
            "OBSRVE]",
            ["line 16, robots.scout_1.repertoire.1", "OBSRVE", "OBSERVE, RELEASE1"],
        ),
        ("verbs.yaml", "observed(?place)", "seen(?place)", ["observe.goals.0", "seen", "observed"]),
        ("verbs.yaml", "kind: place", "kind: planet", ["kind", "place"]),
        (WORLD, "start: [1.4", "strat: [1.4", ["line 16, robots.0.strat"]),
        (WORLD, "robots:", "facts: [{predicate: lit, args: []}]\nrobots:", ["facts", "lit", "observed"]),
    ],
)
def test_what_is_wrong_is_named_with_file_line_slot_and_choices(
    tmp_path: Path, file: str, right: str, wrong: str, words: list[str]
) -> None:
    folder = example(tmp_path)
    change(folder / file, right, wrong)
    faults = "\n".join(faults_of(load_packs([str(folder)])))
    assert [word for word in (*words, str(folder / file)) if word not in faults] == [], faults


def test_an_action_that_no_packet_achieves_is_a_fault(tmp_path: Path) -> None:
    folder = example(tmp_path)
    (folder / LIBRARY).unlink()
    faults = list(faults_of(load_packs([str(folder)])))
    assert faults == [
        f"{folder / BASE}: OBSERVE: no packet of a behaviours library achieves any of observed(ref)"
    ]


def test_a_phase_that_no_packet_achieves_is_a_fault(tmp_path: Path) -> None:
    folder = example(tmp_path)
    change(folder / BASE, "- observed(ref)", "- observed(ref) at end - 2")
    (fault,) = faults_of(load_packs([str(folder)]))
    assert fault == (
        f"{folder / BASE}: OBSERVE has phases: no packet of a behaviours library achieves under_way_observe_1"
    )
    packet = "      - observed(?ref)\n"
    change(folder / LIBRARY, packet, packet + "      - under_way_observe_1(?robot, near, ?ref)\n")
    assert list(faults_of(load_packs([str(folder)]))) == []


def test_every_broken_part_is_told_at_once(tmp_path: Path) -> None:
    folder = example(tmp_path)
    for file, right in ((BASE, "duration: 6"), (PACKET, "about: Face")):
        change(folder / file, right, f"x{right}")
    faults = "\n".join(faults_of(load_packs([str(folder)])))
    assert str(folder / BASE) in faults
    assert str(folder / PACKET) in faults


def test_the_contents_are_names(tmp_path: Path) -> None:
    contents = contents_of(find_pack(str(example(tmp_path))))
    assert (contents.actions, contents.predicates) == (["OBSERVE"], ["observed"])
    assert (contents.packets, contents.worlds) == (["OBSERVE"], ["looks_yard"])


@pytest.mark.parametrize("name", ["Looks", "", "9lives", "a-b", "store", "x" * 65, "../up"])
def test_a_name_that_is_none_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(PackError, match="cannot be a pack's name"):
        write_example(name, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_a_folder_with_something_in_it_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(PackError, match="is not empty"):
        write_example("looks", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_sensed_predicate_needs_its_condition(tmp_path: Path) -> None:
    folder = example(tmp_path)
    change(
        folder / BASE, "arguments: {location: location}", "arguments: {location: location}\n    sensed: true"
    )
    (fault,) = faults_of(load_packs([str(folder)]))
    assert fault.startswith(f"{folder / BASE}: predicates.observed: it is sensed, but no file")
    facts = folder / "repertoire" / "facts.yaml"
    facts.write_text("sensed_facts:\n  - {fact: observed($ref), by: {sense: in_view, target: $ref}}\n")
    assert list(faults_of(load_packs([str(folder)]))) == []
    assert contents_of(find_pack(str(folder))).senses == ["observed($ref)"]
