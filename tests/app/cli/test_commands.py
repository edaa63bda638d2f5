"""The commands without a simulation: what they print, what they refuse, how they end."""

import json
import socket
from importlib import import_module, resources
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner, Result

from app.cli.demo import demo
from app.cli.goal_input import read_goals
from app.cli.main import app
from app.packs.find import load_packs
from robots.world import load_world
from tests.app.sample_store import Store


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
    ("change", "why"),
    [
        ({"external": True}, "store_2 does not sense in(sample_1, interchange_2): it senses nothing"),
        (
            {"external": True, "senses": ["clear"]},
            "store_2 does not sense in(sample_1, interchange_2): it senses only clear",
        ),
        ({"external": True, "senses": ["in"]}, ""),
        ({"senses": []}, "store_2 does not sense in(sample_1, interchange_2): it senses nothing"),
        ({}, ""),
    ],
)
def test_plan_knows_what_each_robot_senses_and_says_why_it_waits_for_clearance(
    tmp_path: Path, change: dict[str, object], why: str
) -> None:
    robots = load_world("sample_store").model_dump(mode="json")["robots"]
    world = world_file(tmp_path, robots=[one | change if one["name"] == "store_2" else one for one in robots])
    words = ("plan", "--world", world, "--goal", "move sample_1 to bay_7")
    body = json.loads(macta(*words, "--json").stdout)
    assert [one["why"] for one in body["orderings"] if one["kept_by"] == "clearance"] == (
        [why] if why else []
    )
    assert body["clearances"] == bool(why)
    if why and "senses" in change and "external" in change:
        told = " ".join(macta(*words).stdout.split())
        assert f"By clearance: a6 DOCK after a5 RELEASE2, for {why}" in told


def test_plan_keeps_the_terms_of_sentences_and_says_how_they_are_understood() -> None:
    sentence = "move sample_1 to bay_7 without yard_1 in ten minutes"
    done = macta("plan", "--goal", sentence)
    assert done.exit_code == 0
    assert "in ten minutes: in 600 s of the world's clock" in done.stderr
    assert "Constraints: without yard_1" in done.stderr
    planned = macta("plan", "--goal", sentence, "--json")
    assert "yard_1" not in json.loads(planned.stdout)["robots"]
    goals = ("--goal", "send yard_2 to door_1", "--goal", "send yard_1 to door_2 then send store_1 to bay_1")
    staged = macta("plan", *goals, "--json")
    assert "stage" in {ordering["reason"] for ordering in json.loads(staged.stdout)["orderings"]}
    twice = macta("plan", "--goal", sentence, "--deadline", "5")
    assert (twice.exit_code, "say one" in twice.stderr) == (2, True)


@pytest.mark.parametrize(
    ("goal", "code"),
    [
        ("move sample_9 to bay_7", "unknown-sample"),
        ("move sample_1 to bay_2", "place-occupied"),
        ("juggle sample_1", "unknown-verb"),
        ("move sample_1 to bay_7 with yard_2", "constraints-too-tight"),
        ("move sample_1 to bay_7 without yard_9", "unknown-robot"),
        ("inn(sample_1, bay_7)", "unknown-predicate"),
        ("move [/x] to bay_7", "unknown-sample"),
    ],
)
def test_a_goal_that_is_refused_is_one_json_document_and_a_line(goal: str, code: str) -> None:
    refused = macta("plan", "--goal", goal, "--json")
    assert refused.exit_code == 2
    document = json.loads(refused.stdout)
    assert (document["status"], document["code"]) == ("refused", code)
    assert document["choices"]
    assert document["thing"] in goal
    assert refused.stderr.startswith("macta: ")
    assert "Traceback" not in refused.stderr


def test_another_knowledge_base_and_a_fact_as_goal_are_planned_with(tmp_path: Path) -> None:
    ours = (resources.files("planner.knowledge") / "files" / "rovers.yaml").read_text()
    base = tmp_path / "kb.yaml"
    base.write_text(ours.replace('duration: "7"', "duration: 9"))
    words = ("--goal", "tracked(yard_1, yard_2)", "--knowledge-base", str(base), "--deadline", "5")
    done = macta("plan", *words, "--engine", "fast-downward", "--json")
    assert done.exit_code == 0, done.stderr
    body = json.loads(done.stdout)
    assert body["makespan_s"] == 9.0
    assert [late["late_s"] for late in body["late"]] == [4.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [("types: 1", "kb.yaml is not a valid knowledge base: line 1"), (None, "no knowledge base file")],
)
def test_a_knowledge_base_that_is_none_is_refused(tmp_path: Path, text: str | None, words: str) -> None:
    if text is not None:
        (tmp_path / "kb.yaml").write_text(text)
    goal = ("--goal", "tracked(yard_1, yard_2)")
    refused = macta("plan", *goal, "--knowledge-base", str(tmp_path / "kb.yaml"))
    assert refused.exit_code == 2
    assert words in " ".join(refused.stderr.split())


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


@pytest.mark.parametrize("words", [("serve", "--port", "0"), ("demo",)])
def test_a_short_token_is_refused_by_name(monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]) -> None:
    monkeypatch.setenv("MACTA_TOKEN", "abc")
    refused = macta(*words)
    assert refused.exit_code == 2
    assert "MACTA_TOKEN: String should have at least 16 characters" in refused.stderr
    assert "Traceback" not in refused.stderr


def test_a_file_cannot_be_the_folder_of_the_record(tmp_path: Path) -> None:
    file = tmp_path / "passwd"
    file.touch()
    refused = macta("serve", "--port", "0", "--data", str(file))
    assert refused.exit_code == 2
    assert refused.stderr == f"macta: --data: {file} is a file, not a folder\n"


@pytest.mark.parametrize("host", ["192.0.2.1", "::zz"])
def test_a_host_that_is_not_this_machine_is_refused_by_name(tmp_path: Path, host: str) -> None:
    refused = macta("serve", "--port", "0", "--data", str(tmp_path), "--host", host)
    assert refused.exit_code == 2
    assert f"cannot listen on host '{host}'" in refused.stderr
    assert "--port" not in refused.stderr


def test_a_port_in_use_is_refused_by_number(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        refused = macta("serve", "--port", str(port), "--data", str(tmp_path))
    assert refused.exit_code == 2
    assert f"cannot listen on 127.0.0.1:{port}" in refused.stderr


@pytest.mark.parametrize("words", [("--speed", "4"), ("--seed", "0")])
def test_what_is_of_simulated_worlds_is_refused_with_a_broker(tmp_path: Path, words: tuple[str, ...]) -> None:
    given = ("--port", "0", "--data", str(tmp_path), "--broker", "mqtt://127.0.0.1:1")
    refused = macta("serve", *given, *words)
    assert refused.exit_code == 2
    assert "give them to `macta fleet`" in refused.stderr


@pytest.mark.parametrize("ending", [KeyboardInterrupt, typer.Abort])
def test_an_interruption_is_one_line_and_130(
    monkeypatch: pytest.MonkeyPatch, ending: type[BaseException]
) -> None:
    def interrupted(*_: object, **__: object) -> int:
        raise ending

    def left(code: int) -> None:
        raise SystemExit(code)

    # NOTE: `app.cli.main` as an attribute is the entry point, so the modules are asked for by name.
    monkeypatch.setattr(import_module("app.cli.plan"), "plan", interrupted)
    monkeypatch.setattr(import_module("app.cli.options"), "leave", left)
    ended = macta("plan", "--goal", "move sample_1 to bay_7")
    assert ended.exit_code == 130
    assert ended.stderr == "macta: interrupted\n"


def test_the_plan_is_readable_at_80_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = macta("plan", "--goal", "move sample_1 to bay_7").stdout
    assert max(map(len, shown.splitlines())) <= 80
    assert "…" not in shown
    actions = shown.split("Causal links")[0]
    assert actions.count("yard_1 ") >= 4
    assert actions.count("store_2 ") >= 4


@pytest.mark.parametrize("command", [("plan", "--goal", "move sample_1 to bay_7"), ("demo",), ("serve",)])
def test_every_command_refuses_a_world_with_facts_outside_the_vocabulary(
    tmp_path: Path, command: tuple[str, ...]
) -> None:
    world = world_file(tmp_path, facts=[{"predicate": "flies", "args": ["yard_1"]}])
    refused = macta(*command, "--world", world)
    assert refused.exit_code == 2
    assert "unknown predicate 'flies'" in refused.stderr


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
        ({"link": {"loss": 1.5}}, "link.loss"),
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
    assert "yard_1 and robots.yard_2 start nearer than 0.44 m to each other" in refused.stderr


def test_schema_prints_the_json_schema_of_world_files() -> None:
    schema = json.loads(macta("world", "schema").stdout)
    assert {"compartments", "locations", "robots", "samples"} <= set(schema["properties"])


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("nonsense", "MACTA_DATABASE_URL: not of the form postgresql://"),
        ("mysql://operator:swordfish@host/macta", "MACTA_DATABASE_URL: mysql is not supported"),
        ("postgres://operator:swordfish@host/macta", "MACTA_DATABASE_URL: postgres is not supported; give"),
        ("postgresql://operator:swordfish@host:x/macta", "MACTA_DATABASE_URL: not of the form postgresql://"),
        ("sqlite://", "MACTA_DATABASE_URL: names no database file"),
        ("sqlite:////no/such/folder/x.sqlite", "unable to open database file"),
        ("sqlite:///{folder}/noise.sqlite", "file is not a database"),
        ("postgresql://operator:swordfish@127.0.0.1:1/macta", "Connection refused"),
        ("postgresql://operator:swordfish@127.0.0.1:1/macta?bogus=1", 'invalid connection option "bogus"'),
    ],
)
def test_a_database_that_cannot_be_used_is_told_in_one_line_without_its_password(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, url: str, why: str
) -> None:
    (tmp_path / "noise.sqlite").write_bytes(bytes(range(1, 256)) * 40)
    monkeypatch.setenv("MACTA_DATABASE_URL", url.format(folder=tmp_path))
    monkeypatch.setenv("MACTA_TOKEN", "a-token-for-the-tests")
    refused = macta("serve", "--port", "0", "--data", str(tmp_path / "data"))
    assert refused.exit_code == 2
    (line,) = [line for line in refused.stderr.splitlines() if line.startswith("macta: ")]
    assert why in line
    assert "swordfish" not in refused.output
    assert "Traceback" not in refused.output


def test_world_validate_tells_facts_that_contradict_each_other(tmp_path: Path) -> None:
    facts = [{"predicate": "near", "args": ["yard_1", door]} for door in ("door_1", "door_2")]
    refused = macta("world", "validate", world_file(tmp_path, facts=facts))
    assert refused.exit_code == 2
    assert "facts: near(yard_1, door_1) and near(yard_1, door_2) cannot both be true" in refused.stderr


def test_a_free_place_is_chosen_within_the_constraints_of_all_goals() -> None:
    store = Store()
    sentences = ["move sample_1 to any bay", "keep bay_1 empty and park yard_1"]
    stated = read_goals(store.world, store.facts, sentences, store.base)
    assert [str(goal) for goal in stated.goals] == ["in(sample_1, bay_3)", "near(yard_1, home_yard_1)"]


@pytest.mark.parametrize(
    ("sentences", "goals"),
    [
        (("move sample_1 to any bay", "move sample_4 to any bay"), ("bay_1", "bay_3")),
        (("move sample_1 to any bay", "move sample_4 to bay_1"), ("bay_3", "bay_1")),
        (("in(sample_1, bay_1)", "move sample_4 to any bay"), ("bay_1", "bay_3")),
    ],
)
def test_any_bay_is_none_that_another_goal_aims_at(
    sentences: tuple[str, str], goals: tuple[str, str]
) -> None:
    store = Store()
    stated = read_goals(store.world, store.facts, sentences, store.base)
    assert tuple(goal.args[1] for goal in stated.goals) == goals


def test_what_is_kept_empty_for_some_time_is_planned_with_and_shown() -> None:
    result = macta("plan", "--goal", "move sample_1 to any bay and keep bay_1 and bay_2 empty for an hour")
    assert result.exit_code == 0, result.output
    assert "A service will hold bay_1 and bay_2 empty for 1 h" in flat(result.stderr)
    assert "bay_2 is emptied: sample_2 to bay_4" in flat(result.stderr)
    assert "in(sample_1, bay_3)" in flat(result.stdout)


def test_keeping_an_empty_place_empty_needs_no_plan(capsys: pytest.CaptureFixture[str]) -> None:
    result = macta("plan", "--goal", "keep bay_3 empty until further notice")
    assert (result.exit_code, flat(result.stdout).startswith("Nothing to carry out")) == (0, True)
    document = json.loads(macta("plan", "--json", "--goal", "keep bay_3 empty until further notice").stdout)
    assert document == {
        "status": "nothing_to_do",
        "holds": ["will hold bay_3 empty until an operator ends it"],
    }
    assert (
        demo(load_world("sample_store"), load_packs(("store",)), "keep bay_3 empty for an hour", None, 0) == 0
    )
    assert "nothing to carry out" in flat(capsys.readouterr().out)


def test_the_demo_of_a_goal_that_is_true_already_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    world, packs = load_world("sample_store"), load_packs(("store",))
    assert demo(world, packs, "move sample_2 to bay_2", None, 0) == 0
    assert "it is true already" in flat(capsys.readouterr().out)


def test_what_is_kept_where_it_is_is_planned_with_and_shown() -> None:
    goal = "move sample_1 to bay_7 and keep yard_1 at home_yard_1 for an hour"
    result = macta("plan", "--goal", goal)
    assert result.exit_code == 0, result.output
    assert "A service will hold yard_1 at home_yard_1 for 1 h" in flat(result.stderr)
    assert ("yard_2" in result.stdout, "yard_1" in result.stdout.partition("Causal links")[0]) == (
        True,
        False,
    )
    refused = macta("plan", "--goal", "move sample_1 to bay_7 and keep sample_1 in bay_3 for an hour")
    assert (refused.exit_code, "sample_1 cannot be in" in flat(refused.stderr)) == (2, True)


def flat(text: str) -> str:
    """Without the line breaks of the terminal's width."""
    return " ".join(text.split())
