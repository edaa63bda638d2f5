"""Maps of ROS's map_server, imported: what is occupied blocks, what is free stays free, what is wrong is named."""

from math import dist
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robots.world import WorldFile
from robots.world.file import ROBOT_WIDTH_M
from robots.world.grid_world import ros_map_world
from robots.world.parts import Point
from robots.world.ros_map import RosMapError
from robots.world.walls import clearance_m, panels_of

KEYS = {
    "image": "hall.pgm",
    "resolution": "0.05",
    "origin": "[-1, -2, 0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}
OCCUPIED = 0
UNKNOWN = 205
FREE = 254


def two_rooms() -> np.ndarray:
    """Rooms of 4.9 m and 5 m by 5.9 m, from the top; a thin wall with a doorway of 1.2 m, a pillar and two specks."""
    cells = np.full((120, 200), FREE, dtype=np.uint8)
    cells[[0, -1]] = cells[:, [0, -1]] = UNKNOWN
    cells[:, 100:102] = OCCUPIED
    cells[48:72, 100:102] = FREE
    cells[90:94, 40:44] = OCCUPIED
    cells[30, 30] = cells[60, 150] = OCCUPIED
    return cells


def write_map(folder: Path, cells: np.ndarray, **keys: str) -> Path:
    rows, columns = cells.shape
    header = f"P5\n# CREATOR: a map saver\n{columns} {rows} 255\n".encode()
    (folder / "hall.pgm").write_bytes(header + cells.astype(np.uint8).tobytes())
    return write_keys(folder, **keys)


def write_keys(folder: Path, **keys: str) -> Path:
    file = folder / "Hall 2.yaml"
    file.write_text("".join(f"{key}: {value}\n" for key, value in {**KEYS, **keys}.items() if value))
    return file


def imported(file: Path) -> WorldFile:
    return WorldFile.model_validate(ros_map_world(file))


def least_clearance_m(world: WorldFile, start: Point, end: Point) -> float:
    """Along the straight line between two points; negative if it crosses a wall."""
    panels = panels_of(world.walls)
    return min(
        clearance_m(tuple(point), panels) for point in np.linspace(start, end, points_on(dist(start, end)))
    )


def points_on(length_m: float) -> int:
    """So many that they lie a centimetre apart."""
    return int(length_m * 100) + 2


def test_two_rooms_become_six_walls_with_a_doorway_that_robots_pass(tmp_path: Path) -> None:
    world = imported(write_map(tmp_path, two_rooms()))
    assert world.name == "hall_2"
    assert [(floor.x, floor.y) for floor in world.compartments] == [((-0.95, 8.95), (-1.95, 3.95))]
    assert len(world.walls) == 6, "four around, and one on either side of the doorway"
    west, east = (3.0, 1.0), (5.0, 1.0)
    assert least_clearance_m(world, west, east) > ROBOT_WIDTH_M / 2
    for y in np.arange(-1.9, 3.9, 0.07):
        is_seen = least_clearance_m(world, (3.0, y), (5.0, y)) > 0
        is_at_a_jamb = abs(abs(y - 1.0) - 0.6) < 0.05
        assert is_at_a_jamb or is_seen == (0.4 < y < 1.6)


def test_a_pillar_becomes_a_rock_and_a_speck_of_one_cell_is_dropped(tmp_path: Path) -> None:
    (rock,) = imported(write_map(tmp_path, two_rooms())).obstacles
    assert rock.at == pytest.approx((1.1, -0.6))
    assert 0.1 < rock.radius_m < 0.15


def test_what_is_round_but_too_large_for_a_rock_gets_walls(tmp_path: Path) -> None:
    cells = two_rooms()
    row, column = np.mgrid[: cells.shape[0], : cells.shape[1]]
    cells[np.hypot(row - 60, column - 150) < 16] = OCCUPIED  # 1.6 m across
    world = imported(write_map(tmp_path, cells))
    assert len(world.obstacles) == 1, "the pillar"
    assert len(world.walls) > 6
    assert least_clearance_m(world, (6.45, 1.0), (8.5, 1.0)) < 0


def rotated(cells: np.ndarray, angle_rad: float) -> np.ndarray:
    """The cells of a map whose rooms stand at an angle to it."""
    rows, columns = cells.shape
    side = 250
    y, x = np.mgrid[:side, :side] - side / 2
    column = np.rint(x * np.cos(angle_rad) + y * np.sin(angle_rad) + columns / 2).astype(int)
    row = np.rint(y * np.cos(angle_rad) - x * np.sin(angle_rad) + rows / 2).astype(int)
    is_inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    return np.where(is_inside, cells[row.clip(0, rows - 1), column.clip(0, columns - 1)], UNKNOWN)


@pytest.mark.parametrize("angle_rad", [0.0, 0.13, 0.7])
@pytest.mark.parametrize("cell_m", [0.03, 0.05, 0.1])
def test_walls_stand_along_all_of_the_border_and_nowhere_else(
    tmp_path: Path, angle_rad: float, cell_m: float
) -> None:
    cells = rotated(two_rooms(), angle_rad)
    file = write_map(tmp_path, cells, resolution=str(cell_m), origin="[0, 0, 0]")
    world = imported(file)
    assert len(world.walls) <= 20
    free = cells[::-1] == FREE
    touching = np.zeros_like(free)
    touching[1:-1, 1:-1] = free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:]
    panels = panels_of(world.walls)
    within_m = 2 * max(cell_m, 0.08)

    def to_nearest_m(point: Point) -> float:
        rocks = [dist(rock.at, point) - rock.radius_m for rock in world.obstacles]
        return min([clearance_m(point, panels), *rocks])

    border = [(x, y) for y, x in np.argwhere(~free & touching)]
    far = [(x, y) for x, y in border if to_nearest_m(((x + 0.5) * cell_m, (y + 0.5) * cell_m)) > within_m]
    assert len(far) <= 4, "all but the specks"
    occupied = np.argwhere(~free) + 0.5
    for panel in panels:
        for x, y in np.linspace(panel.start, panel.end, points_on(panel.length_m)):
            nearest = np.abs(occupied * cell_m - (y, x)).max(axis=1).min()
            assert nearest <= within_m


def test_the_yaw_of_the_origin_turns_the_world_about_it(tmp_path: Path) -> None:
    straight = imported(write_map(tmp_path, two_rooms(), origin="[0, 0, 0]"))
    turned = imported(write_map(tmp_path, two_rooms(), origin="[3, 1, 1.5707963]"))
    for before, after in zip(straight.walls, turned.walls, strict=True):
        assert after.start == pytest.approx((3 - before.start[1], 1 + before.start[0]), abs=0.002)


def test_floors_that_nothing_joins_become_compartments_and_nooks_are_left_out(tmp_path: Path) -> None:
    cells = two_rooms()
    cells[:, 100:102] = UNKNOWN
    cells[:, 180:182] = UNKNOWN  # leaves 0.85 m
    floors = imported(write_map(tmp_path, cells)).compartments
    assert [floor.x for floor in floors] == [(-0.95, 4.0), (4.1, 8.0)]


def test_floors_that_touch_at_a_corner_are_two_and_walls_part_them(tmp_path: Path) -> None:
    cells = np.full((60, 60), UNKNOWN)
    cells[5:30, 5:30] = cells[30:55, 30:55] = FREE
    world = imported(write_map(tmp_path, cells, resolution="0.1", origin="[0, 0, 0]"))
    assert len(world.compartments) == 2
    assert least_clearance_m(world, (2.5, 3.5), (3.5, 2.5)) < 0


@pytest.mark.parametrize("maxval", [255, 100, 1000])
def test_ascii_and_16_bit_images_are_the_same_map(tmp_path: Path, maxval: int) -> None:
    binary = imported(write_map(tmp_path, two_rooms()))
    shades = np.rint(two_rooms() / 255.0 * maxval).astype(int)
    (tmp_path / "hall.pgm").write_text(
        f"P2 # ascii\n200 120\n{maxval}\n" + "\n".join(" ".join(map(str, row)) for row in shades)
    )
    assert imported(write_keys(tmp_path, free_thresh="0.15")) == binary
    sixteen = f"P5 200 120 {257 * 255}\n".encode() + (two_rooms().astype(">u2") * 257).tobytes()
    (tmp_path / "hall.pgm").write_bytes(sixteen)
    assert imported(write_keys(tmp_path)) == binary


@pytest.mark.parametrize(
    ("keys", "image", "words"),
    [
        (
            {"mode": "scale"},
            None,
            "mode: scale has no free or occupied cells; save the map with mode: trinary",
        ),
        ({"mode": "grey"}, None, "line 7, mode: Input should be 'trinary'"),
        ({"resolution": "0"}, None, "line 2, resolution: "),
        ({"resolution": ""}, None, "resolution: Field required"),
        ({"free_thresh": "0.9"}, None, "free_thresh must be at most occupied_thresh"),
        ({"origin": "[0, 0]"}, None, "line 3, origin"),
        ({"image": r'"\uD800"'}, None, "is not YAML: "),
        ({"image": "none.pgm"}, None, "none.pgm: there is no such file"),
        ({"negate": "1"}, None, "there is no free square of 1 m"),
        ({}, b"\x89PNG\r\n", "hall.pgm: byte 0: no PGM image, which begins with P2 or P5; convert it"),
        ({}, b"P5 3 # x\n", "byte 4: the height must follow, a number from 1 to 16,000,000"),
        ({}, b"P5 3 3 70000 ", "byte 6: the maxval must follow, a number from 1 to 65,535"),
        ({}, b"P5 9000 9000 255 ", "9000 x 9000 cells are more than 16,000,000; crop the map"),
        ({}, b"P5 3 3 255 abc", "byte 14: the image ends after 3 of 9 cells"),
        ({}, b"P2 2 1 255 1 -2", "byte 13: b'-' is no part of a number"),
        ({}, b"P2 2 1 255 1 256", "row 1, column 2: the value is more than maxval, 255"),
    ],
)
def test_what_is_wrong_with_a_map_is_told_with_file_and_key_or_byte(
    tmp_path: Path, keys: dict[str, str], image: bytes | None, words: str
) -> None:
    write_map(tmp_path, two_rooms())
    if image is not None:
        (tmp_path / "hall.pgm").write_bytes(image)
    with pytest.raises(RosMapError) as refused:
        imported(write_keys(tmp_path, **keys))
    assert words in str(refused.value)
    assert str(tmp_path) in str(refused.value)


def test_a_map_of_noise_is_refused(tmp_path: Path) -> None:
    cells = np.random.default_rng(0).choice([OCCUPIED, FREE], size=(1000, 1000))
    cells[:50, :50] = FREE
    with pytest.raises(RosMapError, match="remove noise from the map, or crop it"):
        imported(write_map(tmp_path, cells))


YAML_VALUES = st.one_of(
    st.none(), st.text(max_size=8), st.floats(), st.integers(), st.lists(st.floats(), max_size=4)
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    text=st.one_of(
        st.binary(max_size=60),
        st.dictionaries(st.sampled_from([*KEYS, "mode", "x"]), YAML_VALUES.map(str)).map(
            lambda keys: "".join(f"{key}: {value}\n" for key, value in {**KEYS, **keys}.items()).encode()
        ),
    )
)
def test_a_yaml_file_of_anything_is_read_or_refused(tmp_path: Path, text: bytes) -> None:
    write_map(tmp_path, two_rooms())
    (tmp_path / "Hall 2.yaml").write_bytes(text)
    refused_or_read(tmp_path)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    image=st.one_of(
        st.binary(max_size=60),
        st.tuples(st.sampled_from([b"P2 ", b"P5 "]), st.binary(max_size=60)).map(b"".join),
        st.tuples(st.just(b"P5 30 30 1 "), st.binary(min_size=900, max_size=900)).map(
            lambda parts: parts[0] + bytes(byte < 250 for byte in parts[1])
        ),
        st.tuples(st.just(b"P2 2 2 9 "), st.text("0189 \n", max_size=20).map(str.encode)).map(b"".join),
    ),
    cell_m=st.sampled_from(["0.05", "0.4", "1"]),
)
def test_an_image_of_anything_is_read_or_refused(tmp_path: Path, image: bytes, cell_m: str) -> None:
    write_keys(tmp_path, resolution=cell_m)
    (tmp_path / "hall.pgm").write_bytes(image)
    refused_or_read(tmp_path)


def refused_or_read(folder: Path) -> None:
    try:
        content = ros_map_world(folder / "Hall 2.yaml")
    except RosMapError:
        return
    WorldFile.model_validate(content)
