"""Who may import whom: the rules of the house, read from the code's own imports."""

import ast
from collections.abc import Iterator, Sequence
from functools import cache
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
ORDER = {
    "app": """cli composition api missions planning recordings agents core workflows settings background_compilation
        database_url packs store domain""",
    "planner": """up_engine up_registration repair engines alternatives native_process interchange explanation bounds
        relaxation problem plan_nets knowledge compiled fact errors""",
    "robots": """adapters social deliberative executive repertoire reactive conditions perception physical world
        contract link wire compiled compilation kernels child_processes clock data extensions errors""",
    "sim": """trials process world bodies physics truth snapshot clock error""",
    "web": """viewer live_world recording page_feed world_feed scene document_cache viser_private api_types""",
}
"""The rooms and loose modules of each package, from the top down: each imports only what stands below it."""
MAX_ROOMS = {"app": 10, "planner": 9, "robots": 13, "sim": 5, "web": 1}
MAX_LOOSE = {"app": 5, "planner": 8, "robots": 8, "sim": 8, "web": 8}
"""Modules that may lie beside the rooms of a package, its `__init__` not counted."""


@cache
def modules(package: str) -> list[Path]:
    paths = (path.relative_to(ROOT) for path in (ROOT / package).rglob("*.py"))
    return sorted(
        path for path in paths if "migrations" not in path.parts and "node_modules" not in path.parts
    )


@cache
def import_statements(module: Path) -> Sequence[ast.Import | ast.ImportFrom]:
    """Those of a module, also inside functions and under TYPE_CHECKING."""
    nodes = ast.walk(ast.parse((ROOT / module).read_text()))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def imports(module: Path) -> Iterator[str]:
    """Every module that this one imports."""
    for node in import_statements(module):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
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
def test_every_room_and_loose_module_has_its_place_in_the_order(package: str) -> None:
    units = {module.parts[1].removesuffix(".py") for module in modules(package)} - {"__init__"}
    assert units == set(ORDER[package].split())
    loose = [module for module in modules(package) if len(module.parts) == 2 and module.stem != "__init__"]
    assert len(loose) <= MAX_LOOSE[package]
    assert len(units) - len(loose) <= MAX_ROOMS[package]


@pytest.mark.parametrize("package", sorted(OURS))
def test_rooms_import_only_what_stands_below_them(package: str) -> None:
    order = ORDER[package].split()
    for module, targets in graph(package).items():
        if module == package:
            continue  # the package's public face
        room = module.split(".")[1]
        for target in targets:
            assert target != package, f"{module} imports its own package's face"
            below = target.split(".")[1]
            assert order.index(room) <= order.index(below), (
                f"{module} imports {target}, which stands above it"
            )


@pytest.mark.parametrize("package", sorted(OURS))
def test_no_modules_import_each_other_in_a_circle(package: str) -> None:
    left = graph(package)
    while free := {module for module, targets in left.items() if not targets & left.keys()}:
        left = {module: targets for module, targets in left.items() if module not in free}
    assert not left, f"in a circle, or above one: {sorted(left)}"


def test_the_contract_with_the_service_and_the_world_file_import_no_part_of_a_behavioural_agent() -> None:
    allowed = {
        "wire": {"wire"},
        "link": {"link", "wire"},
        "world": {"world", "wire"},
        "contract": {"contract", "link", "wire"},
        "adapters": {"adapters", "contract", "link", "wire"},
    }
    for room, rooms in allowed.items():
        for module, targets in graph("robots").items():
            if module.startswith(f"robots.{room}"):
                used = {target.split(".")[1] for target in targets} - {
                    "clock",
                    "compilation",
                    "compiled",
                    "data",
                    "errors",
                    "extensions",
                    "kernels",
                }
                assert used <= rooms, module


def test_the_boxes_of_macta_figure_4_are_rooms_or_modules_with_their_names() -> None:
    boxes = {
        "HCI": "web/static",
        "planner": "planner",
        "world model": "app/domain/world_model",
        "knowledge base": "planner/knowledge",
        "mission organiser": "app/domain/mission_organiser",
        "behaviours library": "app/domain/mission_organiser/behaviours_library.py",
        "agent models": "app/agents/agent_models.py",
        "communications": "app/agents/communications.py",
        "mission monitor": "app/domain/mission_monitor.py",
    }
    assert [box for box, place in boxes.items() if not (ROOT / place).exists()] == []


def graph(package: str) -> dict[str, set[str]]:
    """Each module of the package with those of the package that it imports, itself left out."""
    known = {
        ".".join(path.with_suffix("").parts).removesuffix(".__init__"): path for path in modules(package)
    }
    found = {}
    for name, path in known.items():
        targets = set()
        for node in import_statements(path):
            if isinstance(node, ast.Import):
                targets |= {alias.name for alias in node.names}
            elif node.module:
                full = {f"{node.module}.{alias.name}" for alias in node.names}
                targets |= full & known.keys()
                if not full <= known.keys():
                    targets.add(node.module)
        found[name] = targets & known.keys() - {name}
    return found
