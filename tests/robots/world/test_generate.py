"""Generated stores: as many of everything as asked, reachable, with room to stand, the same for a seed."""

from itertools import pairwise
from math import cos, dist, hypot, radians, sin
from pathlib import Path

import pytest

from robots.physical.body import RADIUS_M
from robots.world import (
    StoreShape,
    StoreShapeError,
    WorldFile,
    generate_world,
    load_world,
    store_shape,
    world_yaml,
)
from robots.world.parts import PHASE_TAGS, STORE_TAGS

STAND_OFF_M = 0.6
SHAPES = {
    "default": store_shape(),
    "three compartments": store_shape(samples=6, compartments=3),
    "two robots an aisle": store_shape(store_robots=4, yard_robots=4, interchanges=4, doors=8),
    "bays with berths": store_shape(bay_capacity=3, samples=20),
    "deep bays of robots abreast": store_shape(bay_capacity=2, store_robots=4, samples=6, compartments=3),
    "many robots": store_shape(aisles=3, store_robots=8, yard_robots=7, interchanges=7, bays=20, samples=16),
}


@pytest.fixture(params=SHAPES)
def world(request: pytest.FixtureRequest) -> WorldFile:
    return generate_world(SHAPES[request.param], seed=3)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_there_is_as_much_of_everything_as_asked(shape: StoreShape) -> None:
    world = generate_world(shape)
    kinds = [place.kind for place in world.locations]
    assert (kinds.count("door"), kinds.count("bay")) == (shape.doors, shape.bays)
    assert (kinds.count("interchange"), len(world.samples)) == (shape.interchanges, shape.samples)
    assert len(world.robots) == shape.yard_robots + shape.store_robots
    assert len(world.compartments) == shape.compartments
    assert sum(len(compartment.aisles) for compartment in world.compartments) == shape.aisles


def test_a_world_file_written_and_read_is_the_same_world(world: WorldFile, tmp_path: Path) -> None:
    file = tmp_path / "store.yaml"
    file.write_text(world_yaml(world))
    assert load_world(file) == world


def test_the_seed_alone_decides_where_samples_lie() -> None:
    shape = SHAPES["many robots"]
    assert world_yaml(generate_world(shape, seed=1)) == world_yaml(generate_world(shape, seed=1))
    one, other = generate_world(shape, seed=1), generate_world(shape, seed=2)
    assert one.samples != other.samples
    assert one.model_copy(update={"samples": ()}) == other.model_copy(update={"samples": ()})


def test_samples_can_be_handed_from_any_area_to_any_other(world: WorldFile) -> None:
    """Interchanges join the robots' areas to one; every place is reached by some robot."""
    reach = [{place.name for place in world.reach_of(robot)} for robot in world.robots]
    assert set().union(*reach) == {place.name for place in world.places}
    joined, apart = reach[0], reach[1:]
    while near := [places for places in apart if places & joined]:
        joined = joined.union(*near)
        apart = [places for places in apart if places not in near]
    assert not apart


def test_only_robots_on_both_sides_of_a_hatch_reach_its_interchange(world: WorldFile) -> None:
    for place in world.places:
        areas = {world.area_of(robot).name for robot in world.robots if place in world.reach_of(robot)}
        assert len(areas) == (2 if place.kind == "interchange" else 1), place.name


def test_every_robot_starts_at_its_home_and_every_place_has_room_to_stand_before_it(world: WorldFile) -> None:
    starts = {robot.home: robot.start[:2] for robot in world.robots}
    for place in world.places:
        for axis_deg in place.approach_deg:
            axis = radians(axis_deg)
            stand = (place.at[0] + STAND_OFF_M * cos(axis), place.at[1] + STAND_OFF_M * sin(axis))
            assert all(compartment.x[0] < stand[0] < compartment.x[1] for compartment in world.compartments)
            assert _to_walls_m(world, stand) > RADIUS_M, place.name
            others = [start for home, start in starts.items() if home != place.name]
            assert min(dist(stand, start) for start in others) > 2 * RADIUS_M, place.name
        if place.name in starts:
            assert dist(starts[place.name], place.at) < 1.0


def test_bays_have_room_for_as_many_samples_as_asked() -> None:
    shape = store_shape(bay_capacity=3, samples=20)
    world = generate_world(shape, seed=1)
    rows = [row for name, row in world.places_by_location.items() if name.startswith("bay_")]
    assert [len(row) for row in rows] == [3] * shape.bays
    assert 3 * shape.bays >= 1.5 * shape.samples
    assert len(set(world.initial_places.values())) == 20
    between = [dist(one.at, other.at) for row in rows for one, other in pairwise(row)]
    assert between == pytest.approx([0.7] * len(between))


def test_an_aisle_goes_on_behind_its_bays_as_far_as_its_robots_and_hatches_there_need() -> None:
    rest_m = []
    for shape in (store_shape(), SHAPES["two robots an aisle"], store_shape(compartments=3)):
        world = generate_world(shape)
        north = max(compartment.y[1] for compartment in world.compartments)
        rest_m.append(north - max(place.at[1] for place in world.locations if place.kind == "bay"))
    alone_m, abreast_m, before_a_hatch_m = rest_m
    assert alone_m < abreast_m < before_a_hatch_m


def test_doors_and_hatches_lie_apart_in_their_walls(world: WorldFile) -> None:
    for wall in world.walls:
        for one, other in pairwise(wall.openings):
            assert one.at_m + one.width_m / 2 < other.at_m - other.width_m / 2
        for opening in wall.openings:
            middle = (wall.start[0] + opening.at_m, wall.start[1])
            near = min(dist(middle, place.at) for place in world.places)
            assert near == pytest.approx(0.4 if opening.kind == "door" else 0.0, abs=0.01)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ({"aisles": 0}, "aisles must be at least 1"),
        ({"aisles": 3, "store_robots": 2}, "store robots must be at least 3: each of the 3 aisles needs one"),
        ({"bays": 1}, "bays must be at least 2"),
        ({"yard_robots": 0}, "yard robots must be at least 1"),
        ({"compartments": 1}, "compartments must be at least 2"),
        ({"compartments": 3, "aisles": 3}, "aisles must be a multiple of 2"),
        ({"samples": 15}, None),
        ({"samples": 15, "bays": 12}, "samples must be at most 14"),
        ({"bay_capacity": 0}, "bay capacity must be at least 1"),
        ({"samples": 32, "bays": 9, "bay_capacity": 3}, "samples must be at most 31, 3 a bay, one a door"),
    ],
)
def test_a_shape_that_cannot_be_built_is_refused_by_the_number_that_is_wrong(
    numbers: dict[str, int], said: str | None
) -> None:
    if said is None:
        assert generate_world(store_shape(**numbers)).samples
        return
    with pytest.raises(StoreShapeError, match=said):
        store_shape(**numbers)


def _to_walls_m(world: WorldFile, point: tuple[float, float]) -> float:
    """The distance to the nearest wall, openings or not."""
    return min(_to_segment_m(point, wall.start, wall.end) for wall in world.walls)


def _to_segment_m(point: tuple[float, float], start: tuple[float, float], end: tuple[float, float]) -> float:
    (x, y), (x0, y0), (x1, y1) = point, start, end
    along = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / ((x1 - x0) ** 2 + (y1 - y0) ** 2)
    share = min(1.0, max(0.0, along))
    return hypot(x - x0 - share * (x1 - x0), y - y0 - share * (y1 - y0))


def test_robots_of_a_store_in_phases_have_their_packets_in_its_file_too(tmp_path: Path) -> None:
    plain = generate_world(store_shape())
    assert {robot.repertoire for robot in plain.robots} == {STORE_TAGS}
    file = tmp_path / "store.yaml"
    file.write_text(world_yaml(generate_world(store_shape(), in_phases=True)))
    assert {robot.repertoire for robot in load_world(file).robots} == {(*STORE_TAGS, *PHASE_TAGS)}


def test_the_robots_of_an_area_share_a_charger_in_place_of_homes(tmp_path: Path) -> None:
    file = tmp_path / "store.yaml"
    file.write_text(world_yaml(generate_world(store_shape(yard_robots=3), shared_chargers=True)))
    world = load_world(file)
    assert [place.name for place in world.locations if place.kind in ("home", "charger")] == [
        "charger_yard",
        "charger_aisle_1",
        "charger_aisle_2",
    ]
    served = {robot.name: [place.name for place in world.chargers_of(robot)] for robot in world.robots}
    assert served == {
        **{f"yard_{number}": ["charger_yard"] for number in (1, 2, 3)},
        "store_1": ["charger_aisle_1"],
        "store_2": ["charger_aisle_2"],
    }
