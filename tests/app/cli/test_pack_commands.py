"""`macta pack`, and packs in the other commands."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.main import app
from tests.app.packs.pack_folders import change, example
from tests.packages import installed, write_package

ENTRY_POINTS = """\
[macta.packs]
looks = looks_pack
[macta.conditions]
rested = looks_pack.rested:Rested
"""


def macta(*words: str) -> Result:
    return CliRunner().invoke(app, words)


def site(folder: Path, entry_points: str = ENTRY_POINTS) -> Path:
    """An installed package that brings the pack `looks` and Python."""
    pack = example(folder / "source")
    files = {f"looks_pack/{file.relative_to(pack)}": file.read_text() for file in pack.rglob("*.yaml")}
    rested = "from robots.conditions.own_state import Empty as Rested\n"
    return write_package(
        folder / "site",
        "macta_looks",
        entry_points,
        {**files, "looks_pack/__init__.py": "", "looks_pack/rested.py": rested},
    )


def test_a_new_pack_is_valid_and_its_goal_can_be_planned(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    made = macta("pack", "new", "looks", "--folder", str(folder))
    assert made.exit_code == 0, made.output
    checked = macta("pack", "check", str(folder))
    assert (checked.exit_code, checked.stdout) == (
        0,
        "looks 0.1: valid; actions OBSERVE; packets OBSERVE; verbs observe; worlds looks_yard\n",
    )
    for goal in ("observed(rock_1)", "observe rock_1"):
        planned = macta("plan", "--pack", str(folder), "--world", "looks_yard", "--goal", goal, "--json")
        assert planned.exit_code == 0, planned.output
        assert [action["tag"] for action in json.loads(planned.stdout)["actions"]] == ["NAVIGATE", "OBSERVE"]


def test_a_pack_that_is_not_valid_is_refused_with_its_places(tmp_path: Path) -> None:
    folder = example(tmp_path)
    change(folder / "worlds" / "looks_yard.yaml", "OBSERVE]", "OBSRVE]")
    refused = macta("pack", "check", str(folder))
    assert refused.exit_code == 2
    said = " ".join(refused.stderr.split())
    assert (
        "robots.scout_1.repertoire.1: no packet of a repertoire has the tag 'OBSRVE'; choices: DOCK" in said
    )


@pytest.mark.parametrize(
    "command",
    [
        ("plan", "--goal", "observed(rock_1)"),
        ("demo", "--goal", "observed(rock_1)"),
        ("serve", "--data", "DATA"),
        ("fleet", "--data", "DATA"),
        ("worker",),
        ("alive", "fleet"),
    ],
    ids=" ".join,
)
def test_every_command_refuses_a_pack_that_is_missing(tmp_path: Path, command: tuple[str, ...]) -> None:
    words = [str(tmp_path) if word == "DATA" else word for word in command]
    refused = macta(*words, "--pack", "nowhere")
    assert refused.exit_code == 2
    assert "no domain pack or folder 'nowhere'; choices: store" in " ".join(refused.stderr.split())


def test_the_environment_names_packs_for_every_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MACTA_PACKS", str(example(tmp_path)))
    assert macta("world", "validate", "looks_yard").exit_code == 0
    assert macta("plan", "--world", "looks_yard", "--goal", "observed(rock_1)").exit_code == 0


def test_a_packs_world_is_not_valid_without_the_pack(tmp_path: Path) -> None:
    world = example(tmp_path) / "worlds" / "looks_yard.yaml"
    refused = macta("world", "validate", str(world))
    assert refused.exit_code == 2
    assert "no packet of a repertoire has the tag 'OBSERVE'" in " ".join(refused.stderr.split())


def test_what_is_installed_is_listed(tmp_path: Path) -> None:
    with installed(site(tmp_path)):
        lines = macta("pack", "list").stdout.splitlines()
        document = json.loads(macta("pack", "list", "--json").stdout)
    assert lines[2].startswith("looks 0.1 (package looks_pack of macta_looks 1.2): actions OBSERVE;")
    assert lines[3:] == ["macta.conditions: rested (looks_pack.rested:Rested of macta_looks 1.2)"]
    assert [pack["name"] for pack in document["packs"]] == ["store", "survey", "looks"]
    assert [one["name"] for one in document["extensions"]] == ["rested"]


def test_two_packages_with_one_name_are_told_by_the_list(tmp_path: Path) -> None:
    rival = "[macta.conditions]\nrested = rival:Rested\n"
    with installed(write_package(site(tmp_path), "rival", rival, {})):
        refused = macta("pack", "list")
    assert refused.exit_code == 2
    assert "rested is both" in " ".join(refused.stderr.split())


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("rested = ", "tired = ", "register tired as empty"),
        ("rested:Rested", "rested:Nobody", "cannot be loaded"),
        ("macta.conditions", "macta.stimuli", "no subclass of robots.reactive.stimuli.Stimulus"),
        ("macta.conditions", "macta.moods", "there is no group macta.moods; choices: macta.avoidances"),
    ],
)
def test_the_python_of_an_installed_pack_is_checked(
    tmp_path: Path, right: str, wrong: str, words: str
) -> None:
    with installed(site(tmp_path, ENTRY_POINTS.replace(right, wrong))):
        refused = macta("pack", "check", "looks")
    assert refused.exit_code == 2
    assert words in " ".join(refused.stderr.split())
