"""What a world file may not say, and that the error names the slot."""

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


@pytest.mark.parametrize(
    ("predicate", "args"), [("in", ["sample_1", "bay_2"]), ("vacant", ["bay_1"])], ids=["elsewhere", "vacant"]
)
def test_facts_do_not_contradict_where_a_sample_lies(tmp_path: Path, predicate: str, args: list[str]) -> None:
    said = refusal(tmp_path, facts=[{"predicate": predicate, "args": args}])
    assert f"samples.sample_1.at is bay_1, but the facts say {predicate}({', '.join(args)})" in said


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
        assert "robots.left and robots.right start in the same place" in refusal(tmp_path, robots=robots)


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
