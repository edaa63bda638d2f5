"""The robots' rooms stand in one order: each imports only rooms below its own."""

import ast
from pathlib import Path

import pytest

ROBOTS = Path(__file__).parents[2] / "robots"
LEVELS = ("physical", "perception", "conditions", "reactive", "repertoire", "executive")
"""From the lowest to the highest; `deliberative` and `social` will come above."""
BESIDE = {"wire": {"wire"}, "link": {"link", "wire"}, "world": {"world", "wire"}}
"""Rooms beside the levels, which import no level, and what each may import."""
LOOSE = {"clock", "data", "errors", "kernels"}
"""Modules that import no room; every room may import them."""


def imported_rooms(module: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name.split(".")[1] for name in names if name.startswith("robots.")} - LOOSE


def test_every_room_and_module_has_its_place() -> None:
    rooms = {path.name for path in ROBOTS.iterdir() if (path / "__init__.py").exists()}
    assert rooms == {*LEVELS, *BESIDE}
    assert {path.stem for path in ROBOTS.glob("*.py")} == LOOSE | {"__init__"}


@pytest.mark.parametrize("room", [*LEVELS, *BESIDE, *LOOSE])
def test_a_room_imports_only_rooms_below_it(room: str) -> None:
    if room in LEVELS:
        allowed = {*LEVELS[: LEVELS.index(room) + 1], "wire"} | ({"link"} if room == "executive" else set())
    else:
        allowed = BESIDE.get(room, set())
    modules = (ROBOTS / room).rglob("*.py") if room not in LOOSE else [ROBOTS / f"{room}.py"]
    for module in modules:
        assert imported_rooms(module) <= allowed, module
