"""Doors, hatches and lifts in world files."""

from typing import Any

import pytest
from pydantic import ValidationError

from robots.world import WorldFile, load_world

WORLD = load_world("guarded_store")


def changed(name: str, /, **values: Any) -> WorldFile:
    document = WORLD.model_dump(mode="json")
    document["peripherals"] = [
        one | values if one["name"] == name else one for one in document["peripherals"]
    ]
    return WorldFile.model_validate(document)


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("gate_1", {"start": None}, "gate_1 is a door: give its panel a start and an end"),
        ("gate_1", {"start": [5.5, 7.2], "end": [5.5, 8.2]}, "give the wall a gap there"),
        ("hatch_1", {"start": [2.8, 3.6], "end": [3.2, 3.6]}, "give the wall a hatch there"),
        ("gate_1", {"start": [3.0, 5.7], "end": [3.0, 6.9], "kind": "hatch"}, "has no place in it"),
        (
            "gate_1",
            {"start": [4.8, 5.7], "end": [4.8, 6.9]},
            "locations.gate_west is nearer to it than 0.3 m",
        ),
        ("gate_1", {"capacity": 2}, "capacity"),
        ("gate_1", {"opening_s": 0}, "opening_s"),
        ("gate_1", {"name": "bay_1"}, "bay_1"),
        ("lift_1", {"stops": []}, "it needs a cabin and at least two stops"),
        ("lift_1", {"cabin": {"x": [0, 1], "y": [0, 1]}}, "has no place in its cabin"),
        ("gate_1", {"cabin": {"x": [0, 1], "y": [0, 1]}}, "cabin and stops are of lifts only"),
    ],
)
def test_what_is_wrong_with_a_peripheral_is_told_with_the_way_out(
    name: str, values: dict[str, Any], words: str
) -> None:
    with pytest.raises(ValidationError) as refused:
        changed(name, **values)
    assert words in str(refused.value)


def test_a_world_with_peripherals_survives_its_own_json() -> None:
    assert WorldFile.model_validate_json(WORLD.model_dump_json()) == WORLD


def test_peripherals_are_agents_but_no_robots() -> None:
    assert "gate_1" in WORLD.agents_by_name
    assert "gate_1" not in WORLD.robots_by_name
    assert "gate_1" in WORLD.links


def test_a_real_door_is_not_simulated() -> None:
    world = changed("gate_1", external=True)
    assert "gate_1" not in [one.name for one in world.simulated_peripherals]


def test_a_doorway_without_a_capacity_is_no_zone() -> None:
    assert changed("gate_1", capacity=None).agents_by_name["gate_1"].passage == ""
