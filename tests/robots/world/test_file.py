"""What a world file may not say, and that the error names the slot."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from robots.world import WorldFileError, load_world


def small(**changes: Any) -> dict[str, Any]:
    """A world of one room, two places, two robots and a sample, changed as told."""
    return {
        "name": "room",
        "compartments": [{"name": "floor", "x": [0, 6], "y": [0, 6]}],
        "locations": [
            {"name": "bay_1", "kind": "bay", "at": [1, 1], "approach_deg": [0]},
            {"name": "bay_2", "kind": "bay", "at": [1, 3], "approach_deg": [0]},
        ],
        "robots": [
            {"name": "left", "compartment": "floor", "start": [3, 3, 0]},
            {"name": "right", "compartment": "floor", "start": [3.5, 3, 0]},
        ],
        "samples": [{"name": "sample_1", "at": "bay_1"}],
        **changes,
    }


def refusal(folder: Path, **changes: Any) -> str:
    file = folder / "room.yaml"
    file.write_text(yaml.safe_dump(small(**changes)))
    with pytest.raises(WorldFileError) as refused:
        load_world(file)
    return str(refused.value)


def test_a_small_world_is_valid(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(yaml.safe_dump(small(facts=[{"predicate": "in", "args": ["sample_1", "bay_1"]}])))
    assert load_world(file).name == "room"


def test_a_copy_works_out_anew_what_follows_from_its_parts(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(yaml.safe_dump(small()))
    world = load_world(file)
    assert [*world.agents_by_name] == ["left", "right"]
    assert [*world.model_copy(update={"robots": world.robots[:1]}).agents_by_name] == ["left"]
    assert [*world.agents_by_name] == ["left", "right"]
    assert world.model_copy() == world


@pytest.mark.parametrize(
    ("predicate", "args"), [("in", ["sample_1", "bay_2"]), ("vacant", ["bay_1"])], ids=["elsewhere", "vacant"]
)
def test_facts_do_not_contradict_where_a_sample_lies(tmp_path: Path, predicate: str, args: list[str]) -> None:
    said = refusal(tmp_path, facts=[{"predicate": predicate, "args": args}])
    assert f"samples.sample_1.at is bay_1, but the facts say {predicate}({', '.join(args)})" in said


def test_a_charger_holds_no_samples(tmp_path: Path) -> None:
    charger = {"name": "charger_1", "kind": "charger", "at": [1, 1], "approach_deg": [0]}
    said = refusal(tmp_path, locations=[charger], samples=[])
    assert "locations.charger_1: a charger holds no samples, capacity must be 0" in said


@pytest.mark.parametrize(("apart_m", "valid"), [(0.0, False), (0.43, False), (0.45, True)])
def test_robots_start_at_least_their_width_apart(tmp_path: Path, apart_m: float, valid: bool) -> None:
    robots = [
        {"name": "left", "compartment": "floor", "start": [3, 3, 0]},
        {"name": "right", "compartment": "floor", "start": [3, 3 + apart_m, 90]},
    ]
    if valid:
        file = tmp_path / "room.yaml"
        file.write_text(yaml.safe_dump(small(robots=robots)))
        assert len(load_world(file).robots) == 2
    else:
        assert "robots.left and robots.right start nearer than 0.44 m to each other" in refusal(
            tmp_path, robots=robots
        )


def test_a_file_that_is_no_text_is_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(WorldFileError, match=r"room\.yaml cannot be read"):
        load_world(file)


def test_a_rock_does_not_stand_where_a_robot_starts_nor_on_a_location(tmp_path: Path) -> None:
    on_robot = {"name": "rock", "at": [3.2, 3.3], "radius_m": 0.2}
    assert "obstacles.rock at (3.2, 3.3) stands where robots.left starts" in refusal(
        tmp_path, obstacles=[on_robot]
    )
    on_bay = {"name": "rock", "at": [1.3, 1], "radius_m": 0.2, "jitter_m": 0.2}
    assert "obstacles.rock at (1.3, 1.0) covers locations.bay_1" in refusal(tmp_path, obstacles=[on_bay])


def test_a_rock_stands_in_a_compartment(tmp_path: Path) -> None:
    said = refusal(tmp_path, obstacles=[{"name": "rock", "at": [7, 1], "radius_m": 0.2}])
    assert "lies in no compartment" in said


def test_a_long_object_has_room_for_two_robots_side_by_side(tmp_path: Path) -> None:
    said = refusal(tmp_path, samples=[{"name": "beam", "at": "bay_1", "length_m": 0.5}])
    assert "samples.0.length_m" in said
    assert "0 is a compact sample" in said


def test_the_relocation_laboratory_has_two_robots_a_long_object_and_rocks_on_the_way() -> None:
    lab = load_world("relocation_lab")
    assert len(lab.robots) == 2
    assert [sample.length_m for sample in lab.samples] == [0.9]
    assert len(lab.obstacles) >= 3


BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12)
)
"""Three hundred thousand million values in twelve lines."""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "line 6: more than 500000 values"),
        ("name: " + "[" * 5000 + "]" * 5000, "line 1: nested more than 50 deep"),
        ("name: room\ntitle: &a [*a]", "line 2: the alias *a has no anchor before it"),
        ("name: " + "9" * 5000, "5000 digits"),
        ("name: 2026-99-99", "month must be in 1..12"),
    ],
    ids=["bomb", "deep", "within itself", "digits", "date"],
)
def test_a_file_that_would_take_for_ever_to_read_is_refused_in_one_line(
    tmp_path: Path, text: str, words: str
) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(text)
    with pytest.raises(WorldFileError) as refused:
        load_world(file)
    assert str(refused.value).startswith(f"{file} cannot be read: ")
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_aliases_are_read_as_what_they_name(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    text = yaml.safe_dump(small())
    file.write_text(
        text.replace("- approach_deg:\n  - 0", "- approach_deg: &east\n  - 0", 1).replace(
            "- approach_deg:\n  - 0", "- approach_deg: *east"
        )
    )
    assert [place.approach_deg for place in load_world(file).locations] == [(0,), (0,)]


WALL = {"start": [0, 3], "end": [6, 3]}
ONE_SPOT = [
    {"name": "bay_1", "kind": "bay", "at": [1, 1], "approach_deg": [0]},
    {"name": "bay_2", "kind": "bay", "at": [1, 1], "approach_deg": [0]},
]


@pytest.mark.parametrize(
    ("changes", "item", "words"),
    [
        ({"walls": [WALL]}, "left", "robots.left starts at (3, 3), in walls.0 from (0, 3) to (6, 3)"),
        ({"walls": [{"start": [0, 2.8], "end": [6, 2.8]}]}, "left", "its middle must be 0.22 m from it"),
        (
            {"walls": [{"start": [0, 1], "end": [6, 1]}]},
            "bay_1",
            "locations.bay_1 lies at (1, 1), in walls.0",
        ),
        ({"locations": ONE_SPOT}, "bay_2", "locations.bay_2 at (1, 1) is 0.00 m from locations.bay_1"),
    ],
    ids=["robot in a wall", "wall through a robot", "place in a wall", "two places on one spot"],
)
def test_a_building_that_cannot_be_is_refused_with_its_place_in_the_file(
    tmp_path: Path, changes: dict[str, Any], item: str, words: str
) -> None:
    said = refusal(tmp_path, **changes)
    assert words in said
    (line,) = re.findall(r"line (\d+), ", said)
    rest = (tmp_path / "room.yaml").read_text().splitlines()[int(line) - 1 :]
    assert next(one for one in rest if "name: " in one).endswith(item)


def test_a_robot_may_stand_in_a_gap_and_a_place_lie_in_a_hatch(tmp_path: Path) -> None:
    hatch = {"kind": "hatch", "at_m": 1, "width_m": 0.4}
    gap = {"kind": "gap", "at_m": 3.25, "width_m": 2}
    file = tmp_path / "room.yaml"
    file.write_text(yaml.safe_dump(small(walls=[{**WALL, "openings": [hatch, gap]}])))
    assert load_world(file).locations[1].at == (1, 3)


def test_an_error_names_the_line_of_its_slot(tmp_path: Path) -> None:
    said = refusal(tmp_path, samples=[{"name": "sample_1", "at": "bay_1", "length_m": -1}])
    lines = (tmp_path / "room.yaml").read_text().splitlines()
    line = next(number for number, one in enumerate(lines, start=1) if "length_m: -1" in one)
    assert f"line {line}, samples.0.length_m: " in said


def test_tags_are_those_of_the_repertoires_that_are_present(tmp_path: Path) -> None:
    robots = [{**one, "repertoire": ["INSPECT"]} for one in small()["robots"]]
    file = tmp_path / "room.yaml"
    file.write_text(yaml.safe_dump(small(robots=robots)))
    assert load_world(file, tags=["INSPECT", "PATROL"]).robot("left").repertoire == ("INSPECT",)
    with pytest.raises(WorldFileError) as refused:
        load_world(file, tags=["PATROL", "NAVIGATE"])
    assert "room.yaml is not a valid world" in str(refused.value)
    lines = file.read_text().splitlines()
    for robot in ("left", "right"):
        place = re.search(rf"line (\d+), robots\.{robot}\.repertoire\.0: .*'INSPECT'", str(refused.value))
        assert place is not None
        assert lines[int(place[1]) - 1].strip() == "- INSPECT"
    assert "choices: NAVIGATE, PATROL" in str(refused.value)


def test_a_tag_is_a_word_in_capitals(tmp_path: Path) -> None:
    robots = [{**one, "repertoire": ["inspect"]} for one in small()["robots"]]
    assert "robots.0.repertoire.0" in refusal(tmp_path, robots=robots)


def test_named_worlds_may_be_any_files(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(yaml.safe_dump(small()))
    assert load_world("lounge", worlds={"lounge": file}).name == "room"
    with pytest.raises(WorldFileError, match="worlds: lounge"):
        load_world("sample_store", worlds={"lounge": file})
