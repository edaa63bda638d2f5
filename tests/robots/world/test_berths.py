"""A location with room for several samples is a row of berths, laid out where robots can dock at each."""

from itertools import pairwise
from math import dist
from pathlib import Path
from typing import Any

import pytest
import yaml

from robots.world import WorldFile, WorldFileError, load_world, world_yaml

HALL = {"name": "hall", "x": [0, 6], "y": [0, 6]}
BACK = {"name": "back", "x": [0, 6], "y": [6, 12]}


def location(name: str, at: list[float], *, capacity: int = 1, **more: Any) -> dict[str, Any]:
    return {"name": name, "kind": "rack", "at": at, "approach_deg": [0], "capacity": capacity, **more}


def hall(*locations: dict[str, Any], team: int = 2, **changes: Any) -> dict[str, Any]:
    """A walled hall with the locations, and robots in its middle."""
    return {
        "name": "hall",
        "compartments": [HALL],
        "walls": [
            {"start": [0, 0], "end": [6, 0]},
            {"start": [0, 6], "end": [6, 6]},
            {"start": [0, 0], "end": [0, 6]},
        ],
        "locations": list(locations),
        "robots": [{"name": f"r{n}", "compartment": "hall", "start": [3 + n, 3, 0]} for n in range(team)],
        **changes,
    }


def valid(*locations: dict[str, Any], **changes: Any) -> WorldFile:
    return WorldFile.model_validate(hall(*locations, **changes))


def refusal(folder: Path, *locations: dict[str, Any], **changes: Any) -> str:
    file = folder / "hall.yaml"
    file.write_text(yaml.safe_dump(hall(*locations, **changes)))
    with pytest.raises(WorldFileError) as refused:
        load_world(file)
    return str(refused.value)


def points(world: WorldFile, name: str) -> list[tuple[float, float]]:
    return [berth.at for berth in world.places_by_location[name]]


def test_berths_lie_across_the_way_that_robots_come_from_around_the_location() -> None:
    world = valid(location("rack_1", [0.5, 3], capacity=3), location("bay_1", [5, 5]))
    assert [place.name for place in world.places] == ["rack_1_1", "rack_1_2", "rack_1_3", "bay_1"]
    assert points(world, "rack_1") == [(0.5, 2.3), (0.5, 3.0), (0.5, 3.7)]
    assert {place.capacity for place in world.places} == {1}
    assert points(valid(location("dock", [3, 0.5], capacity=2, approach_deg=[90])), "dock") == [
        (2.65, 0.5),
        (3.35, 0.5),
    ]


def test_a_berth_is_approached_along_the_first_direction_and_back_only() -> None:
    world = valid(location("table", [3, 3], capacity=2, approach_deg=[90, 0, -90, 180]))
    assert {berth.approach_deg for berth in world.places_by_location["table"]} == {(90, -90)}


def test_what_has_room_for_one_or_none_stays_as_it_is() -> None:
    world = valid(location("bay_1", [1, 1]), location("home", [1, 3], capacity=0))
    assert world.places == world.locations


def test_a_file_keeps_what_its_author_wrote(tmp_path: Path) -> None:
    rack = location("rack_1", [0.5, 3], capacity=3, berth_pitch_m=0.6)
    world = valid(rack, samples=[{"name": "sample_1", "at": "rack_1"}])
    file = tmp_path / "written.yaml"
    file.write_text(world_yaml(world))
    assert load_world(file) == world
    assert yaml.safe_load(file.read_text())["locations"] == [rack]
    assert load_world(file).places_by_location == world.places_by_location


def test_berths_draw_together_where_there_is_less_room() -> None:
    tight = valid(location("rack_1", [0.5, 3], capacity=3), location("bay_1", [0.5, 4.1]))
    assert points(tight, "rack_1") == [(0.5, 2.4), (0.5, 3.0), (0.5, 3.6)]


def test_rows_beside_each_other_share_the_room() -> None:
    one, other = location("rack_1", [0.5, 2.3], capacity=3), location("rack_2", [0.5, 3.7], capacity=3)
    world = valid(one, other, team=1)
    heights = [y for _, y in points(world, "rack_1") + points(world, "rack_2")]
    assert min(above - below for below, above in pairwise(heights)) == pytest.approx(0.45)


def test_where_robots_stand_abreast_berths_are_no_nearer_than_half_a_metre(tmp_path: Path) -> None:
    one, other = location("rack_1", [0.5, 2.3], capacity=3), location("rack_2", [0.5, 3.7], capacity=3)
    assert "berth rack_1_3 at (0.5, 2.8) is 0.40 m from rack_2_1" in refusal(tmp_path, one, other)


def test_several_samples_start_in_the_berths_of_one_location() -> None:
    samples = [{"name": f"sample_{n}", "at": at} for n, at in ((1, "rack_1"), (2, "rack_1_1"), (3, "rack_1"))]
    world = valid(location("rack_1", [0.5, 3], capacity=3), samples=samples)
    assert world.initial_places == {"sample_1": "rack_1_2", "sample_2": "rack_1_1", "sample_3": "rack_1_3"}


@pytest.mark.parametrize(
    ("at", "said"),
    [
        (["rack_1"] * 3, "rack_1 has room for 2 samples, but 3 start there"),
        (["rack_1", "rack_1", "rack_1_1"], "rack_1 has room for 2 samples, but 3 start there"),
        (["rack_1_1", "rack_1_1"], "rack_1_1 has room for 1 sample, but 2 start there"),
        (["rack_1_3"], "unknown location 'rack_1_3'; choices: rack_1, rack_1_1, rack_1_2"),
    ],
)
def test_no_more_samples_start_than_there_are_berths(tmp_path: Path, at: list[str], said: str) -> None:
    samples = [{"name": f"sample_{n}", "at": place} for n, place in enumerate(at)]
    assert said in refusal(tmp_path, location("rack_1", [0.5, 3], capacity=2), samples=samples)


def test_facts_of_the_file_may_name_the_location_or_the_berth_of_a_sample(tmp_path: Path) -> None:
    rack, samples = location("rack_1", [0.5, 3], capacity=2), [{"name": "sample_1", "at": "rack_1"}]
    for place in ("rack_1", "rack_1_1"):
        fact = {"predicate": "in", "args": ["sample_1", place]}
        assert valid(rack, samples=samples, facts=[fact]).initial_places == {"sample_1": "rack_1_1"}
    elsewhere = {"predicate": "in", "args": ["sample_1", "rack_1_2"]}
    said = refusal(tmp_path, rack, samples=samples, facts=[elsewhere])
    assert "samples.sample_1.at is rack_1_1, but the facts say in(sample_1, rack_1_2)" in said


@pytest.mark.parametrize(
    ("rack", "said"),
    [
        (
            location("rack_1", [0.5, 0.9], capacity=3),
            "berth rack_1_1 at (0.5, 0.4) is too near to the wall (0, 0) to (6, 0): 0.36 m free 0.8 m in front of it",
        ),
        (
            location("rack_1", [0.5, 3], capacity=3, berth_pitch_m=1.2),
            "has no room for 3 berths 1.2 m apart: berth rack_1_3 at (0.5, 4.2) is 0.30 m from bay_1, 0.5 m is needed",
        ),
        (
            location("rack_1", [5.5, 5.9], capacity=2, approach_deg=[180], berth_pitch_m=0.9),
            "berth rack_1_2 at (5.5, 6.35) lies outside hall",
        ),
        (
            location("rack_1", [1.3, 4.7], capacity=2, approach_deg=[-90], berth_pitch_m=0.6),
            "berth rack_1_1 at (1.0, 4.7) stands where robots come to bay_1",
        ),
        (
            location("rack_1", [1.0, 3.6], capacity=2, approach_deg=[90], berth_pitch_m=0.9),
            "berth rack_1_1 at (0.55, 3.6) is approached over bay_1",
        ),
    ],
    ids=["at a wall", "at another location", "outside", "before another location", "behind another location"],
)
def test_berths_without_room_are_refused_with_what_is_in_the_way(
    tmp_path: Path, rack: dict[str, Any], said: str
) -> None:
    words = refusal(tmp_path, rack, location("bay_1", [0.5, 4.5]))
    assert said in words
    assert "locations.rack_1 has no room for" in words
    assert "change its at, capacity or berth_pitch_m" in words


def joined(hatch_m: float) -> dict[str, Any]:
    """Two compartments with a hatch between them, at which an interchange has two berths."""
    opening = {"kind": "hatch", "at_m": 3, "width_m": hatch_m}
    wall = {"start": [0, 6], "end": [6, 6], "openings": [opening]}
    interchange = location("interchange_1", [3, 6], capacity=2, approach_deg=[90, -90], kind="interchange")
    robots = [
        {"name": "south", "compartment": "hall", "start": [3, 3, 0]},
        {"name": "north", "compartment": "back", "start": [3, 9, 0]},
    ]
    return hall(interchange, compartments=[HALL, BACK], walls=[wall], robots=robots)


def test_an_interchange_has_several_berths_where_its_hatch_is_wide_enough() -> None:
    world = WorldFile.model_validate(joined(1.0))
    assert dist(*points(world, "interchange_1")) == pytest.approx(0.6)
    assert {robot.name: len(world.reach_of(robot)) for robot in world.robots} == {"south": 2, "north": 2}


def test_an_interchange_in_a_narrow_hatch_has_no_room_for_several(tmp_path: Path) -> None:
    said = refusal(tmp_path, **joined(0.4))
    assert "locations.interchange_1 has no room for 2 berths" in said
    assert "each berth needs a hatch of its own, or one hatch wide enough for all" in said


def test_berths_have_names_of_their_own(tmp_path: Path) -> None:
    said = refusal(tmp_path, location("rack_1", [0.5, 3], capacity=2), location("rack_1_2", [5, 5]))
    assert "names must be unique in a world, names of berths included; used more than once: rack_1_2" in said


@pytest.mark.parametrize("kind", ["home", "bay"])
def test_a_home_has_no_berths(tmp_path: Path, kind: str) -> None:
    home = location("base", [0.5, 3], capacity=2, kind=kind)
    robots = [{"name": "r0", "compartment": "hall", "start": [3, 3, 0], "home": "base"}]
    assert "a home has n" in refusal(tmp_path, home, robots=robots)
