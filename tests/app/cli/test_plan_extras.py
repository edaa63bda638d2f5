"""`macta plan` with alternatives and an explanation."""

import json
import re

import pytest
from rich.console import Console
from typer.testing import CliRunner

from app.cli.main import app
from app.cli.plan import ExtrasRequest
from app.domain.plan_document import PlanBody
from app.domain.world_model import planning_problem
from planner import Observer, PlanningRequest, PlanningResult, PlanningStatus
from planner.engines.fast_downward import FastDownwardEngine
from tests.app.sample_store import Store

STORE = Store()
GOAL = ("plan", "--goal", "move sample_1 to bay_7", "--engine", "macta", "--time-limit", "300")


def test_json_holds_the_plan_and_with_it_what_was_asked_for() -> None:
    done = CliRunner().invoke(app, [*GOAL, "--json", "--alternatives", "4", "--explain"])
    assert done.exit_code == 0
    document = json.loads(done.stdout)
    assert set(document) == {"plan", "alternatives", "explanation"}
    labels = [one["label"] for one in document["alternatives"]]
    assert labels[0].startswith("shortest time")
    assert "without yard_1" in labels
    assert [one["action"] for one in document["explanation"]["actions"]] == [
        action["id"] for action in document["plan"]["actions"]
    ]
    assert "yard_2 instead of yard_1" in document["explanation"]["robots"]["yard_1"]


def test_an_explanation_tells_what_each_constraint_costs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    given = ["plan", "--goal", "move sample_1 to bay_7 without yard_1 avoiding bay_3", *GOAL[3:], "--explain"]
    document = json.loads(CliRunner().invoke(app, [*given, "--json"]).stdout)
    costs = {one["constraint"]: one for one in document["explanation"]["constraints"]}
    assert list(costs) == ["without yard_1", "avoiding bay_3"]
    assert costs["without yard_1"]["at_least_s"] > 1.0
    assert costs["avoiding bay_3"]["at_least_s"] == 0.0
    words = " ".join(CliRunner().invoke(app, given).stdout.split())
    for constraint, cost in costs.items():
        assert f"{constraint}: {cost['words']}" in words


def test_a_terminal_shows_a_table_of_plans_and_the_reasons(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    done = CliRunner().invoke(app, [*GOAL, "--alternatives", "2", "--explain"])
    words = " ".join(done.stdout.split())
    assert "without yard_1 57.4" in words
    assert "no other robot reaches bay_7" in words
    assert "brings about that sample_1 is in bay_7: a goal" in words
    assert "What determines the makespan" in words


def test_a_plan_tells_when_goals_are_likely_achieved_and_how_likely_in_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    done = CliRunner().invoke(
        app, [*GOAL, "--deadline", "60", "--objective", "on_time", "--alternatives", "2"]
    )
    words = " ".join(done.stdout.split())
    assert re.search(r"On time: [1-9]\d % that its deadline is kept", words)
    assert re.search(
        r"in\(sample_1, bay_7\): [1-9]\d % by 60 s; half of the time within \d+ s, 10 to 90 % in", words
    )
    assert re.search(r"To clear On time Robots", words)
    without = CliRunner().invoke(app, [*GOAL, "--json"])
    likely = json.loads(without.stdout)["forecast"]
    assert likely["on_time"] is None
    assert likely["goals"][0]["p10_s"] < likely["goals"][0]["p90_s"]


def test_a_goal_may_be_one_that_is_not_to_be_true_yet() -> None:
    document = json.loads(CliRunner().invoke(app, [*GOAL, "--json", "--not-before", "200"]).stdout)
    (last,) = [action for action in document["actions"] if action["not_before_s"]]
    assert last["earliest_start_s"] == last["not_before_s"] == 200
    assert document["critical_path"] == [last["id"]]
    assert document["forecast"]["goals"][0]["p10_s"] > 200


def test_what_is_optional_is_left_out_if_the_deadline_is_too_near(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    optional = ("--optional", "5: move sample_2 to bay_3", "--optional", "2: move sample_3 to bay_8")
    terms = [*GOAL, *optional, "--deadline", "70"]
    words = " ".join(CliRunner().invoke(app, terms).stdout.split())
    assert "Left out, worth 2: in(sample_3, bay_8): no plan is quick enough for it" in words
    assert "Optional goals achieved are worth 5 (no choice is worth more)" in words
    document = json.loads(CliRunner().invoke(app, [*terms, "--json", "--alternatives", "2"]).stdout)
    assert [one["goal"]["args"] for one in document["plan"]["left_out"]] == [["sample_3", "bay_8"]]
    assert all(one["goals"] == document["plan"]["goals"] for one in document["alternatives"])


def test_preferences_are_told_with_what_they_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    text = "move sample_1 to bay_7 preferably without yard_1 (cost 5) and preferably avoiding bay_3"
    terms = ["plan", "--goal", text, *GOAL[3:]]
    done = CliRunner().invoke(app, terms)
    words = " ".join(done.stdout.split())
    assert "preferably without yard_1 (cost 5 s)" in done.stderr
    assert (
        "Not kept, at a cost of 5 s: preferably without yard_1: the shortest plan found that keeps it"
        in words
    )
    assert "Kept: preferably avoiding bay_3" in words
    assert "Makespan and costs are 55 s together (proven: of no plan below 55 s)" in words
    document = json.loads(
        CliRunner().invoke(app, [*terms, "--json", "--alternatives", "3", "--explain"]).stdout
    )
    plan = document["plan"]
    assert (plan["preferences"]["cost_s"], plan["preferences"]["cut_short"]) == (5.0, False)
    for one in document["alternatives"]:
        first, second = one["preferences"]["outcomes"]
        assert (first["kept"], second["kept"]) == ("yard_1" not in one["robots"], True)
    (cost,) = document["explanation"]["constraints"]
    assert (cost["constraint"], cost["at_least_s"]) == ("preferably avoiding bay_3", 0.0)


@pytest.mark.parametrize("optional", ["move sample_2 to bay_3", "0: move sample_2 to bay_3", "much: x", "5:"])
def test_an_optional_goal_needs_a_value(optional: str) -> None:
    refused = CliRunner().invoke(app, [*GOAL, "--optional", optional])
    assert refused.exit_code == 2
    assert "say what the goal is worth" in " ".join(refused.stderr.split())


def test_without_a_plan_no_extras_are_sought() -> None:
    problem = planning_problem(STORE.world, STORE.facts, (STORE.fact("in(sample_1, bay_7)"),))
    none = PlanningResult(status=PlanningStatus.NOT_FOUND, engine="none", planning_s=0.0)
    extras = ExtrasRequest(alternatives=3, explanation=True).find(
        FastDownwardEngine(STORE.base), STORE.base, problem, PlanningRequest(), Observer(), none
    )
    assert (extras.alternatives, extras.explanation) == (None, None)


def test_what_was_not_asked_for_is_not_shown() -> None:
    problem = planning_problem(STORE.world, STORE.facts, (STORE.fact("in(sample_1, bay_7)"),))
    plan_net = STORE.store_sample_1()
    solved = PlanningResult(status=PlanningStatus.SOLVED, engine="hand", planning_s=0.0, plan_net=plan_net)
    extras = ExtrasRequest().find(
        FastDownwardEngine(STORE.base), STORE.base, problem, PlanningRequest(), Observer(), solved
    )
    body = PlanBody.of_plan_net(plan_net, STORE.base)
    assert extras.document(body) == body.model_dump(mode="json")
    console = Console()
    with console.capture() as capture:
        extras.show(console, body)
    assert capture.get() == ""
