"""Operators' orders at every stage of a mission, also while a robot is out of contact: kept, delivered, truly told."""

import time
from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from robots.wire import ScriptState
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.waiting import ENDED, read_until

Thing = dict[str, Any]
YARDS = {"yard_1", "yard_2"}
Reach = Callable[[str], str]


def acknowledged(mission: Thing) -> bool:
    return bool(mission["progress"]) and all(s["delivery"] == "acknowledged" for s in mission["progress"])


@pytest.fixture
def reach(api: TestClient, start: Start, follow: Follow, team: FakeTeam) -> Reach:
    """`reach("unknown")` brings a mission to that stage; answers its path."""

    def dispatching() -> str:
        team.faults.lost = 1_000_000
        mission, _ = start("ask")
        follow(mission, "dispatching")
        return mission

    def running() -> str:
        team.faults.stuck.add("store_2")
        mission, _ = start("ask")
        follow(mission, "running")
        read_until(api, mission, acknowledged)
        return mission

    def unknown() -> str:
        mission = running()
        team.faults.silent.add("store_2")
        follow(mission, "unknown")
        return mission

    def deciding() -> str:
        mission, _ = start("ask", fails="DOCK")
        read_until(api, mission, lambda now: now["recovery"]["step"] == "deciding")
        return mission

    def stuck() -> str:
        team.faults.refuses = set(YARDS)
        mission, _ = start("ask")
        asked = read_until(api, mission, lambda now: now["recovery"]["step"] in ("deciding", "stuck"))
        if asked["recovery"]["step"] == "deciding":
            api.post(f"/v1/plans/{asked['recovery']['attempts'][-1]['plan_id']}:approve")
        read_until(api, mission, lambda now: now["recovery"]["step"] == "stuck")
        return mission

    stages = {stage.__name__: stage for stage in (dispatching, running, unknown, deciding, stuck)}
    return lambda stage: stages[stage]()


def contact(team: FakeTeam) -> None:
    team.faults.lost = 0
    team.faults.silent.clear()


STAGES = ("dispatching", "running", "unknown", "deciding", "stuck")


@pytest.mark.parametrize("stage", STAGES)
def test_a_mission_can_be_cancelled_at_every_stage(
    stage: str, reach: Reach, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission = reach(stage)
    answer = api.post(f"{mission}:cancel", json={"comment": "no more"})
    assert answer.status_code == 202, answer.text
    if stage in ("dispatching", "unknown"):
        kept = read_until(api, mission, lambda now: "cancelled by the operator" in now["reason"])
        assert kept["state"] not in ENDED
        assert any(script["order"] == "cancel" for script in kept["progress"])
        paused = api.post(f"{mission}:pause")
        assert (paused.status_code, paused.json()["type"]) == (409, "urn:macta:problem:being-cancelled")
        contact(team)
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["failure"]) == ("cancelled", "cancelled")
    assert all(robot.state in (None, *FINAL) for robot in team.robots.values())
    if stage == "deciding":
        plan = api.get(f"/v1/plans/{ended['recovery']['attempts'][-1]['plan_id']}").json()
        assert plan["state"] == "expired"
    goal = api.get(f"/v1/goals/{ended['goal_id']}").json()
    assert (goal["state"], goal["outcome"]) == ("finished", "cancelled")
    for verb in ("cancel", "pause", "resume"):
        late = api.post(f"{mission}:{verb}")
        assert late.status_code in (202, 409)
        assert api.get(mission).json()["state"] == "cancelled"


FINAL = (ScriptState.FINISHED, ScriptState.FAILED, ScriptState.CANCELLED)


def _deeds(team: FakeTeam) -> dict[str, int]:
    """How much each robot has done; a robot that hears of the mission only now has done nothing."""
    return {name: len(robot.deeds) for name, robot in team.robots.items() if robot.deeds}


@pytest.mark.parametrize("stage", STAGES)
def test_a_mission_can_be_paused_and_resumed_at_every_stage(
    stage: str, reach: Reach, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission = reach(stage)
    before = api.get(mission).json()
    assert api.post(f"{mission}:pause").json()["state"] == "paused"
    if stage == "unknown":
        silent = next(s for s in api.get(mission).json()["progress"] if s["robot"] == "store_2")
        assert silent["order"] == "pause"
    contact(team)
    if stage == "deciding":
        api.post(f"/v1/plans/{before['recovery']['attempts'][-1]['plan_id']}:approve")
    read_until(api, mission, lambda now: not any(script["order"] for script in now["progress"]))
    deeds = _deeds(team)
    time.sleep(1.0)
    assert _deeds(team) == deeds
    assert api.get(mission).json()["state"] == "paused"
    resumed = api.post(f"{mission}:resume")
    assert resumed.status_code == 202
    assert resumed.json()["state"] != "paused"
    team.faults.stuck.clear()
    team.faults.refuses.clear()
    if stage == "stuck":
        assert resumed.json()["recovery"]["step"] == "stuck"
        assert api.post(f"{mission}:cancel").status_code == 202
        assert follow(mission, *ENDED)["state"] == "cancelled"
    else:
        ended = follow(mission, *ENDED)
        assert ended["state"] == "completed", ended["reason"]


@pytest.mark.parametrize("stage", ["dispatching", "running", "unknown", "deciding"])
def test_only_what_is_paused_or_stuck_can_be_resumed(stage: str, reach: Reach, api: TestClient) -> None:
    refused = api.post(f"{reach(stage)}:resume")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:not-paused")


@pytest.mark.parametrize("stage", ["running", "unknown"])
def test_a_paused_mission_can_be_cancelled(
    stage: str, reach: Reach, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission = reach(stage)
    api.post(f"{mission}:pause")
    api.post(f"{mission}:cancel")
    contact(team)
    assert follow(mission, *ENDED)["state"] == "cancelled"
    assert team.robots["store_2"].state is ScriptState.CANCELLED
