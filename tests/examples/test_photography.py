"""The example package is as small as it is said to be, rests on documented modules, and is what the tutorial shows."""

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from app.cli.goal_input import read_goals
from app.cli.trials.offline_mission import goal_problem
from app.domain.world_model import initial_facts
from app.packs.check import faults_of
from app.packs.extensions import extension_faults
from app.packs.find import load_packs
from planner import PlanningRequest, PlanningStatus
from planner.engines.registry import engine_named
from robots.world import load_world
from tests.packages import installed, write_project
from tests.test_architecture import OURS, imports

ROOT = Path(__file__).parents[2]
PROJECT = Path("examples/photography")
TEXTS = (".py", ".toml", ".yaml")
FILES = sorted(path.relative_to(ROOT) for path in (ROOT / PROJECT).rglob("*") if path.suffix in TEXTS)
MODULES = [path for path in FILES if path.suffix == ".py"]
MAX_LINES = 149
LISTING = re.compile(r"^`(?P<path>examples/photography/[^`]+)`:\n\n```\w+\n(?P<text>.*?)^```$", re.M | re.S)


def documented() -> Iterator[str]:
    """The modules that docs/packs.md says are there for packages."""
    _, _, section = (ROOT / "docs/packs.md").read_text().partition("\n## Modules for packages\n")
    for row in re.findall(r"^\| (`.*?) \|", section, re.M):
        yield from re.findall(r"`([\w.]+)`", row)


def is_module(name: str) -> bool:
    path = ROOT.joinpath(*name.split("."))
    return path.is_dir() or path.with_suffix(".py").exists()


def test_the_package_has_less_than_150_lines() -> None:
    assert len(FILES) > len(MODULES) > 2
    assert sum(len((ROOT / path).read_text().splitlines()) for path in FILES) <= MAX_LINES


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_a_module_of_the_package_imports_only_documented_ones_of_ours(module: Path) -> None:
    known = set(documented())
    for name in imports(module):
        if name.partition(".")[0] in OURS:
            parent, _, last = name.rpartition(".")
            is_public_name = parent in known and not last.startswith("_") and not is_module(name)
            assert name in known or is_public_name, name


@pytest.mark.parametrize("module", list(documented()))
def test_a_documented_module_is_there(module: str) -> None:
    assert module.partition(".")[0] in OURS
    import_module(module)


def test_the_tutorial_shows_every_file_of_the_package_as_it_is() -> None:
    shown = {
        Path(found["path"]): found["text"]
        for found in LISTING.finditer((ROOT / "docs/extending.md").read_text())
    }
    assert shown == {path: (ROOT / path).read_text() for path in FILES}


def test_the_package_is_valid_and_its_engine_plans_a_sentence_of_its_verb(tmp_path: Path) -> None:
    with installed(write_project(tmp_path, ROOT / PROJECT)):
        packs = load_packs(["photography"])
        assert [*faults_of(packs), *extension_faults("photography")] == []
        knowledge_base = packs.knowledge_base()
        world = load_world(packs.worlds()["studio"], worlds={}, tags=packs.repertoire().tags)
        facts = initial_facts(world, knowledge_base)
        sentence = "photograph bay_3 and bay_4 with camera by 14:30"
        stated = read_goals(world, facts, [sentence], knowledge_base, packs.verbs())
        problem = goal_problem(world, facts, stated.goals, knowledge_base, stated.constraints)
        found = engine_named("draft", knowledge_base).plan(problem, PlanningRequest())
    assert (found.status, found.engine) == (PlanningStatus.SOLVED, "draft")
    assert found.plan_net is not None
    places = [one.arguments["ref"] for one in found.plan_net.actions if one.tag == "PHOTOGRAPH"]
    assert sorted(places) == ["bay_3", "bay_4"]
