"""`macta experiment sweep`: rows and a rate, from goals to the simulated world's truth."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import pytest
from typer.testing import CliRunner, Result

import app.cli.sweep
from app.cli.main import app as macta
from app.cli.simulated_mission import simulate_mission
from app.cli.sweep import SweepRequest, row_of
from app.cli.trials.offline_mission import organised_mission
from app.cli.trials.sweep_results import Outcome, SeedResult
from app.packs.find import load_packs
from robots.world import load_world
from tests.app.sample_store import Store

MAIN = "move sample_1 to bay_7"


def told(*words: str) -> Result:
    return CliRunner().invoke(macta, ["experiment", "sweep", *words])


@pytest.fixture
def in_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """No processes, and no simulation: seed 1 fails, seed 2 has no plan."""

    def row(seed: int) -> SeedResult:
        fine = SeedResult(seed=seed, goal=MAIN, outcome=Outcome.CAME_TRUE, took_s=48.0, estimate_s=50.0)
        failed = replace(fine, outcome=Outcome.FAILED, packet="DOCK", reason="it sees no [sample_1]")
        unplanned = SeedResult(seed=seed, goal=MAIN, outcome=Outcome.UNPLANNED, reason="unsolvable")
        return [fine, failed, unplanned][seed]

    def runs(_: Callable[[int], SeedResult], jobs: Sequence[int], *, workers: int) -> Iterator[SeedResult]:
        assert workers == 2
        return map(row, jobs)

    monkeypatch.setattr(app.cli.sweep, "run_parallel", runs)


@pytest.mark.usefixtures("in_turn")
def test_every_seed_is_a_row_and_the_rate_has_its_interval() -> None:
    shown = told("--seeds", "3", "--jobs", "2")
    assert shown.exit_code == 0
    rows = [line.split() for line in shown.stdout.splitlines()[1:6]]
    assert rows[0][:6] == ["0", "came", "true", "48.0", "0.96", "move"]
    assert "DOCK: it sees no [sample_1]" in shown.stdout
    assert "1 of 2 came true: 50.0 % (95 %: 9.5 to 90.5)." in shown.stdout
    assert "1 × failed: DOCK: it sees no [sample_1] (seeds 1)" in shown.stdout
    assert "1 × unplanned: unsolvable (seeds 2)" in shown.stdout


@pytest.mark.usefixtures("in_turn")
def test_json_is_one_document() -> None:
    shown = told("--seeds", "3", "--jobs", "2", "--json")
    document = json.loads(shown.stdout)
    assert document["world"] == "sample_store"
    assert [row["outcome"] for row in document["rows"]] == ["came_true", "failed", "unplanned"]
    assert document["rows"][0]["ratio"] == 0.96
    assert document["summary"]["rate"] == 0.5
    assert document["summary"]["failures"][0]["seeds"] == [1]


@pytest.mark.parametrize(
    ("words", "named"),
    [(("--goal", "move sample_9 to bay_7"), "sample_9"), (("--goals", "5"), "fewer goals")],
)
def test_goals_that_no_seed_can_take_are_refused_before_anything_is_started(
    words: tuple[str, ...], named: str
) -> None:
    refused = told(*words)
    assert refused.exit_code == 2
    assert named in " ".join(refused.stderr.split())


def test_a_seeds_row_comes_from_the_simulated_worlds_truth() -> None:
    request = SweepRequest(
        world=load_world("sample_store"), packs=load_packs(["store"]), sentences=(), goals=1
    )
    one = row_of(request, 0)
    assert one.outcome is Outcome.CAME_TRUE, one.reason
    assert one.took_s is not None
    assert 0 < one.took_s < 120


def test_robots_that_finish_without_the_goal_being_true_do_not_count() -> None:
    store = Store()
    mission = organised_mission(store.world, store.store_sample_1(), store.base)
    elsewhere = replace(
        mission, goals=[goal.model_copy(update={"args": ("sample_1", "bay_8")}) for goal in mission.goals]
    )
    ended = simulate_mission(elsewhere, seed=0)
    assert ended.outcome is Outcome.UNTRUE
    assert ended.reason == "in(sample_1, bay_8) is not true: it is in bay_7"


def test_a_robot_that_fails_ends_the_run_with_its_packet_and_its_words() -> None:
    """There is no sample to dock with, and nobody waits long for it."""
    store = Store()
    mission = organised_mission(store.world, store.store_sample_1(), store.base)
    hasty = [
        script.model_copy(
            update={"packets": tuple(p.model_copy(update={"wait_timeout_s": 2.0}) for p in script.packets)}
        )
        for script in mission.scripts
    ]
    empty = store.world.model_copy(update={"samples": ()})
    ended = simulate_mission(replace(mission, world=empty, scripts=hasty), seed=0)
    assert (ended.outcome, ended.packet) == (Outcome.FAILED, "DOCK")
    assert ended.reason
