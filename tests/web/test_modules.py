"""The console's modules stand in one order: no module and no folder imports what imports it."""

import re
from graphlib import TopologicalSorter
from pathlib import Path

STATIC = Path(__file__).parents[2] / "web" / "static"
FIRST_LOAD_BYTES = 150_000
"""Of the console's own files, uncompressed, that every page fetches before anything is chosen on it."""
AT_ONCE = re.compile(r'^(?:import|export) (?:[^;]*? from )?"(\.[^"]+)"', re.MULTILINE)
"""An import that is not left to a later call."""
IMPORT = re.compile(r'(?:from|import\() ?"(\.[^"]+\.js)"')


def imports() -> dict[Path, set[Path]]:
    """What each module imports, also later; both relative to the static folder."""
    return {
        module.relative_to(STATIC): {
            (module.parent / name).resolve().relative_to(STATIC)
            for name in IMPORT.findall(module.read_text())
        }
        for module in STATIC.rglob("*.js")
    }


def fetched_at_once(module: Path, found: set[Path]) -> set[Path]:
    """The module and all that it imports at once, added to those found."""
    if module not in found:
        found.add(module)
        for name in AT_ONCE.findall(module.read_text()):
            fetched_at_once((module.parent / name).resolve(), found)
    return found


def test_a_first_load_fetches_no_more_than_its_budget() -> None:
    page = STATIC / "index.html"
    named = [STATIC / name for name in re.findall(r'(?:href|src)="([\w./]+)"', page.read_text())]
    (entry,) = [file for file in named if file.suffix == ".js"]
    files = {page, *named} | fetched_at_once(entry.resolve(), set())
    assert len(files) > 30
    assert sum(file.stat().st_size for file in files) <= FIRST_LOAD_BYTES


def test_no_module_imports_itself_through_others() -> None:
    TopologicalSorter(imports()).prepare()


def test_no_folder_imports_itself_through_others() -> None:
    folders: dict[Path, set[Path]] = {}
    for module, imported in imports().items():
        folder = folders.setdefault(module.parent, set())
        folder |= {other.parent for other in imported if other.parent != module.parent}
    TopologicalSorter(folders).prepare()
