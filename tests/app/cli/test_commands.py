"""The commands without a simulation: what they print, what they refuse, how they end."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from app.cli.main import app
from robots.world import load_world


def macta(*words: str) -> Result:
    return CliRunner().invoke(app, words)


def world_file(folder: Path, **changes: object) -> str:
    """The sample store with changes, as a file."""
    path = folder / "world.yaml"
    path.write_text(json.dumps({**load_world("sample_store").model_dump(mode="json"), **changes}))
    return str(path)


def test_plan_prints_the_plan_body_as_one_json_document() -> None:
    done = macta("plan", "--goal", "move sample_1 to bay_7", "--json")
    assert done.exit_code == 0
    body = json.loads(done.stdout)
    assert body["goals"] == [{"predicate": "in", "args": ["sample_1", "bay_7"]}]
    assert {"actions", "causal_links", "orderings", "makespan_s", "engine", "planning_s"} <= set(body)


@pytest.mark.parametrize(
    ("goal", "code"),
    [
        ("move sample_9 to bay_7", "unknown-sample"),
        ("move sample_1 to bay_2", "place-occupied"),
        ("juggle sample_1", "unknown-verb"),
        ("move [/x] to bay_7", "unknown-sample"),
    ],
)
def test_a_goal_that_is_refused_is_one_json_document_and_a_line(goal: str, code: str) -> None:
    refused = macta("plan", "--goal", goal, "--json")
    assert refused.exit_code == 2
    document = json.loads(refused.stdout)
    assert (document["status"], document["code"]) == ("refused", code)
    assert document["choices"]
    assert refused.stderr.startswith("macta: ")
    assert "Traceback" not in refused.stderr


def test_a_goal_is_refused_before_any_world_is_started() -> None:
    refused = macta("demo", "--goal", "move sample_9 to [bold]bay_7[/x]")
    assert refused.exit_code == 2
    assert "sample_9" in refused.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("demo", "--seed", "-1"),
        ("serve", "--port", "70000"),
        ("plan",),
        ("world", "validate", "nowhere.yaml"),
    ],
)
def test_wrong_options_are_said_in_words(words: tuple[str, ...]) -> None:
    refused = macta(*words)
    assert refused.exit_code == 2
    assert refused.exception is None or isinstance(refused.exception, SystemExit)


def test_a_short_token_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MACTA_TOKEN", "abc")
    refused = macta("serve", "--port", "0")
    assert refused.exit_code == 2
    assert "setting token" in refused.stderr


def test_validate_accepts_the_shipped_world_and_a_copy(tmp_path: Path) -> None:
    for name in ("sample_store", world_file(tmp_path)):
        done = macta("world", "validate", name)
        assert done.exit_code == 0
        assert "4 robots" in done.stdout


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"samples": [{"name": "sample_1", "at": "bay_99"}]}, "bay_99"),
        ({"facts": [{"predicate": "flies", "args": ["yard_1"]}]}, "flies"),
        ({"link": {"loss": 0.5}}, "link"),
        ({"weather": "dusty"}, "weather"),
    ],
)
def test_validate_names_what_is_wrong(tmp_path: Path, changes: dict[str, object], named: str) -> None:
    refused = macta("world", "validate", world_file(tmp_path, **changes))
    assert refused.exit_code == 2
    assert named in refused.stderr


def test_two_robots_cannot_start_in_the_same_place(tmp_path: Path) -> None:
    robots = load_world("sample_store").model_dump(mode="json")["robots"]
    robots[1] = {**robots[0], "name": "yard_2"}
    refused = macta("world", "validate", world_file(tmp_path, robots=robots))
    assert refused.exit_code == 2
    assert "yard_1 and robots.yard_2 start in the same place" in refused.stderr


def test_schema_prints_the_json_schema_of_world_files() -> None:
    schema = json.loads(macta("world", "schema").stdout)
    assert {"compartments", "locations", "robots", "samples"} <= set(schema["properties"])
