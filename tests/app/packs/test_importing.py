"""Worlds from other formats, read by what an installed package registers."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.main import app
from robots.world import load_world
from tests.packages import installed, write_package

ENTRY_POINTS = """\
[macta.importers]
rows = row_maps:read
halves = row_maps:read_half
gone = row_maps:nothing
"""
PYTHON = """\
def read(file):
    name, width, depth = file.read_text().split()
    return {
        "name": name,
        "compartments": [{"name": "floor", "x": [0, float(width)], "y": [0, float(depth)]}],
        "locations": [{"name": "bay_1", "kind": "bay", "at": [1, 1], "approach_deg": [0]}],
        "robots": [{"name": "left", "compartment": "floor", "start": [3, 3, 0]}],
    }


def read_half(file):
    return {name: part for name, part in read(file).items() if name != "robots"}
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "map.rows").write_text("hall 6 5")
    (tmp_path / "bad.rows").write_text("hall 6 wide")
    return write_package(tmp_path, "row_maps", ENTRY_POINTS, {"row_maps.py": PYTHON})


def imported(site: Path, *words: str) -> Result:
    with installed(site):
        return CliRunner().invoke(app, ("world", "import", *words))


def test_an_imported_world_is_written_as_a_world_file(site: Path) -> None:
    done = imported(site, "rows", str(site / "map.rows"), "--out", str(site / "hall.yaml"))
    assert done.exit_code == 0, done.stderr
    world = load_world(site / "hall.yaml")
    assert (world.name, world.compartments[0].x, world.robots[0].name) == ("hall", (0, 6), "left")


def test_a_map_of_ros_needs_no_package(tmp_path: Path) -> None:
    cells = " ".join("0" if x in (0, 39) or y in (0, 29) else "254" for y in range(30) for x in range(40))
    (tmp_path / "on.pgm").write_text(f"P2 40 30 255 {cells}")
    (tmp_path / "on.yaml").write_text(
        "{image: on.pgm, resolution: 0.1, origin: [0, 0, 0], negate: 0, occupied_thresh: 0.65, free_thresh: 0.2}"
    )
    done = CliRunner().invoke(
        app, ("world", "import", "ros_map", str(tmp_path / "on.yaml"), "--out", str(tmp_path / "world.yaml"))
    )
    assert done.exit_code == 0, done.stderr
    world = load_world(tmp_path / "world.yaml")
    assert (world.name, len(world.walls), world.compartments[0].x) == ("on", 4, (0.1, 3.9))


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        ("columns", "map.rows", "no importer 'columns'; choices: gone, halves, ros_map, rows"),
        (
            "rows",
            "bad.rows",
            "bad.rows cannot be imported as rows: could not convert string to float: 'wide'",
        ),
        ("rows", "none.rows", "none.rows cannot be imported as rows: [Errno 2]"),
        ("halves", "map.rows", "halves (row_maps:read_half of row_maps 1.2) makes no valid world"),
        ("gone", "map.rows", "gone cannot be loaded from row_maps:nothing of row_maps 1.2"),
    ],
)
def test_what_cannot_be_imported_is_refused_with_its_reason(
    site: Path, kind: str, name: str, words: str
) -> None:
    refused = imported(site, kind, str(site / name))
    assert refused.exit_code == 2
    assert words in " ".join(refused.stderr.split())
