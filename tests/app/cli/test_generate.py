"""`macta world generate`: what it writes and what it refuses."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.main import app
from robots.world import load_world


def generate(*words: str) -> Result:
    return CliRunner().invoke(app, ("world", "generate", *words))


def test_the_file_is_a_valid_world_of_the_asked_size(tmp_path: Path) -> None:
    file = tmp_path / "store.yaml"
    written = generate(
        "--aisles", "3", "--yard-robots", "5", "--samples", "9", "--seed", "4", "--out", str(file)
    )
    assert (written.exit_code, written.stdout) == (0, "")
    world = load_world(file)
    assert (len(world.robots), len(world.samples)) == (8, 9)
    assert CliRunner().invoke(app, ("world", "validate", str(file))).exit_code == 0


def test_bays_may_have_berths(tmp_path: Path) -> None:
    file = tmp_path / "store.yaml"
    assert generate("--bay-capacity", "3", "--out", str(file)).exit_code == 0
    said = CliRunner().invoke(app, ("world", "validate", str(file))).stdout
    assert "12 locations (4 of them with 12 berths)" in said


def test_without_a_file_the_world_is_printed_the_same_each_time() -> None:
    printed = generate("--seed", "2").stdout
    assert printed.startswith("name: generated_store\n")
    assert printed == generate("--seed", "2").stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--aisles", "3", "--store-robots", "2"), "store robots must be at least 3"),
        (("--compartments", "1"), "--compartments"),
        (("--out", "/nowhere/store.yaml"), "--out: /nowhere/store.yaml cannot be written"),
    ],
)
def test_what_cannot_be_built_or_written_is_said_in_words(words: tuple[str, ...], said: str) -> None:
    refused = generate(*words)
    assert refused.exit_code == 2
    assert said in refused.stderr
    assert "Traceback" not in refused.stderr
