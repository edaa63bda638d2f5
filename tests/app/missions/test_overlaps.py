"""Things that happen at once, or too early: approvals that clash, pauses before dispatch, restarts, dying planners."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.domain.errors import Unavailable
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.world import load_world
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.waiting import read_until, until

Follow = Callable[..., dict[str, Any]]


def post(api: TestClient, text: str, **more: Any) -> str:
    answer = api.post("/v1/goals", json={"text": text, **more})
    assert answer.status_code == 202, answer.text
    return f"/v1/goals/{answer.json()['id']}"


def test_automatic_approvals_that_need_the_same_robots_run_one_after_the_other(
    api: TestClient, follow: Follow
) -> None:
    goals = [
        post(api, text, auto_approve=True)
        for text in ("move sample_1 to bay_7", "move sample_4 to door_2", "move sample_3 to bay_8")
    ]
    for goal in goals:
        assert follow(goal, "finished", "unsolvable")["outcome"] == "completed"


def test_a_mission_paused_before_its_scripts_are_sent_waits_and_then_runs(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    plan_id = follow(post(api, "move sample_1 to bay_7"), "planned")["plan_id"]
    team.faults.stuck = {
        "yard_1",
        "yard_2",
        "store_1",
        "store_2",
    }  # should the scripts be quicker than the operator, nobody moves yet
    mission = f"/v1/missions/{api.post(f'/v1/plans/{plan_id}:approve').json()['mission_id']}"
    assert api.post(f"{mission}:pause").json()["state"] == "paused"
    read_until(api, mission, lambda now: not any(one["order"] for one in now["progress"]))
    team.faults.stuck = set()
    time.sleep(0.5)
    assert api.get(mission).json()["state"] == "paused"
    assert not any(robot.executed for robot in team.robots.values())
    assert api.post(f"{mission}:resume").status_code == 202
    assert follow(mission, "completed", "partially_completed", "failed")["state"] == "completed"


def test_a_deadline_runs_from_the_goals_submission(api: TestClient, follow: Follow, team: FakeTeam) -> None:
    before_s = team.clock.now_s()
    goal = follow(post(api, "move sample_1 to bay_7", deadline_s=5.0), "planned")
    assert "after the deadline" in goal["reason"]
    assert api.get(f"/v1/plans/{goal['plan_id']}").json()["reason"] == goal["reason"]
    mission_id = api.post(f"/v1/plans/{goal['plan_id']}:approve").json()["mission_id"]
    ended = follow(f"/v1/missions/{mission_id}", "completed")
    assert before_s + 5.0 <= ended["deadline_s"] < ended["started_at_s"]
    assert "after the deadline" in ended["reason"]
    assert ended["failure"] == "deadline"


def service_on(folder: Path, team: FakeTeam, worker: PlanningWorker) -> Service:
    settings = Settings(data=folder, token=TOKEN, database_url=None, answer_patience_s=0.6)
    world = RunningWorld(
        file=load_world("sample_store"), link=team.link, clock=team.clock, rate=None, run=team.run
    )
    return Service(settings, [world], worker=worker)


def test_after_a_new_start_nothing_of_an_ended_mission_is_delivered(
    tmp_path: Path, worker: PlanningWorker
) -> None:
    with FakeTeam() as team:
        team.faults.lost = 10_000
        with service_on(tmp_path, team, worker) as first, TestClient(first.api) as api:
            api.headers["authorization"] = f"Bearer {TOKEN}"
            goal = post(api, "move sample_1 to bay_7", auto_approve=True)
            until(lambda: any(message_id.endswith(":request") for message_id in team.arrived))
    with (
        FakeTeam(run="another run") as team,
        service_on(tmp_path, team, worker) as second,
        TestClient(second.api) as api,
    ):
        api.headers["authorization"] = f"Bearer {TOKEN}"
        mission = api.get(f"/v1/missions/{api.get(goal).json()['mission_id']}").json()
        assert (mission["state"], mission["failure"]) == ("failed", "world_changed")
        assert {script["delivery"] for script in mission["progress"]} == {"withdrawn"}
        time.sleep(2.0)
        assert team.arrived == []


def test_a_data_folder_serves_one_service_at_a_time(tmp_path: Path, worker: PlanningWorker) -> None:
    with (
        FakeTeam() as team,
        service_on(tmp_path, team, worker),
        pytest.raises(Unavailable, match="another service uses"),
    ):
        service_on(tmp_path, team, worker)


def test_goals_survive_the_death_of_the_planning_process(
    api: TestClient, follow: Follow, worker: PlanningWorker
) -> None:
    goals = [post(api, f"move sample_4 to bay_{number}") for number in (7, 8, 9, 10)]
    (process_id,) = worker.pids
    os.kill(process_id, signal.SIGKILL)
    for goal in goals:
        assert follow(goal, "planned", "unsolvable")["state"] == "planned"
