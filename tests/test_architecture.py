"""Who may import whom: the rules of the house, read from the code's own imports."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
OURS = {"app", "planner", "robots", "sim", "web"}
MAY_IMPORT = {
    "planner": {"planner"},
    "robots": {"robots"},
    "sim": {"sim", "robots"},
    "web": {"web"},
    "app": {"app", "planner", "robots"},
}
WIRING = {Path("app/composition.py"), *(p.relative_to(ROOT) for p in (ROOT / "app" / "cli").glob("*.py"))}
"""The composition root and the command line: the only places that wire everything together."""
SERVICE_SIDE = {Path("robots/world")}
"""World files: known to simulation and service, not to a robot."""
LONGEST_MODULE = 300


def modules(package: str) -> list[Path]:
    return sorted(path.relative_to(ROOT) for path in (ROOT / package).rglob("*.py"))


def imports(module: Path) -> Iterator[str]:
    """Every module that this one imports, also inside functions and under TYPE_CHECKING."""
    for node in ast.walk(ast.parse((ROOT / module).read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: relative imports hide who imports whom"
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def ours(module: Path) -> set[str]:
    return {name.split(".")[0] for name in imports(module)} & OURS


@pytest.mark.parametrize("package", sorted(OURS))
def test_packages_import_only_what_they_may(package: str) -> None:
    assert modules(package), f"no modules in {package}"
    for module in modules(package):
        if module in WIRING:
            continue
        wrong = ours(module) - MAY_IMPORT[package]
        assert not wrong, f"{module} imports {sorted(wrong)}"


def test_a_robot_never_sees_the_simulators_truth_nor_the_world_file() -> None:
    for module in modules("robots"):
        if any(module.is_relative_to(folder) for folder in SERVICE_SIDE):
            continue
        names = set(imports(module))
        assert not any(name.startswith(("robots.world", "pybullet", "sim")) for name in names), module


def test_the_simulations_truth_is_read_by_control_channel_and_command_line_only() -> None:
    """Inside `app` only the command line's demo may look at the truth; the web never."""
    readers = {
        module
        for package in ("app", "web", "planner")
        for module in modules(package)
        if any(name.startswith("sim") for name in imports(module))
    }
    assert readers <= WIRING


def test_the_planner_does_no_io_of_the_service() -> None:
    forbidden = {"sqlalchemy", "fastapi", "dbos", "uvicorn", "pybullet", "viser", "httpx2"}
    for module in modules("planner"):
        assert not {name.split(".")[0] for name in imports(module)} & forbidden, module


def test_only_one_package_knows_the_workflow_engine() -> None:
    users = {m for p in OURS for m in modules(p) if any(n.split(".")[0] == "dbos" for n in imports(m))}
    assert {module.parent for module in users} == {Path("app/workflows")}


@pytest.mark.parametrize("package", sorted(OURS))
def test_no_module_outgrows_a_room(package: str) -> None:
    for module in modules(package):
        assert len((ROOT / module).read_text().splitlines()) <= LONGEST_MODULE, module
