"""The console's modules stand in one order: no module and no folder imports what imports it."""

import re
from graphlib import TopologicalSorter
from pathlib import Path

STATIC = Path(__file__).parents[2] / "web" / "static"
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


def test_no_module_imports_itself_through_others() -> None:
    TopologicalSorter(imports()).prepare()


def test_no_folder_imports_itself_through_others() -> None:
    folders: dict[Path, set[Path]] = {}
    for module, imported in imports().items():
        folder = folders.setdefault(module.parent, set())
        folder |= {other.parent for other in imported if other.parent != module.parent}
    TopologicalSorter(folders).prepare()
