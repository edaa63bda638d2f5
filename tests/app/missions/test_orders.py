"""Orders on scripts and their answers, on a whole service."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.agents.agent_models import Reception
from app.composition import Service
from robots.wire import (
    Acknowledgement,
    Message,
    Performative,
    ScriptState,
    StatusReport,
)
from tests.app.fake_robots import FakeTeam
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]


@pytest.fixture
def mission(api: TestClient, follow: Follow, team: FakeTeam) -> str:
    """The path of a mission of which store_2 is at work for good."""
    team.faults.stuck.add("store_2")
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "recovery": "never"}).json()
    plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
    mission_id = api.post(f"/v1/plans/{plan_id}:approve", json={}).json()["mission_id"]
    mission = f"/v1/missions/{mission_id}"
    follow(mission, "running")
    until(lambda: script_of(api, mission)["delivery"] == "acknowledged")
    return mission


def script_of(api: TestClient, mission: str) -> dict[str, Any]:
    (script,) = (one for one in api.get(mission).json()["progress"] if one["robot"] == "store_2")
    return script


def test_a_record_that_has_lost_count_of_its_orders_goes_on_from_what_the_robot_says(
    mission: str, api: TestClient, team: FakeTeam
) -> None:
    team.robots["store_2"].order = 7
    api.post(f"{mission}:pause")
    until(lambda: team.robots["store_2"].state is ScriptState.PAUSED)
    assert team.robots["store_2"].order == 8
    api.post(f"{mission}:resume")
    until(lambda: team.robots["store_2"].state is ScriptState.RUNNING)
    assert team.robots["store_2"].order == 9


def test_how_a_script_stands_is_what_the_robot_said_last_not_what_came_last(
    mission: str, api: TestClient, team: FakeTeam
) -> None:
    team.tick_s = 0.0  # or the robot is asked because it is late, and heard again
    script, at_s = script_of(api, mission)["script_id"], team.clock.now_s()
    said = {
        team.report("store_2", StatusReport(script_id=script, state=state, at_s=at_s + later_s))
        for later_s, state in ((1.0, ScriptState.RUNNING), (0.0, ScriptState.PAUSED))
    }
    until(lambda: said <= set(team.receipts))
    assert script_of(api, mission)["heard_at_s"] == at_s + 1.0
    assert (script_of(api, mission)["state"], script_of(api, mission)["order"]) == ("running", None)


def test_the_answer_to_an_order_that_was_replaced_settles_nothing(
    mission: str, api: TestClient, service: Service, team: FakeTeam
) -> None:
    script = script_of(api, mission)["script_id"]
    team.faults.silent.add("store_2")
    for verb in ("pause", "resume"):
        api.post(f"{mission}:{verb}")
    late = Message(
        performative=Performative.AGREE,
        sender="store_2",
        receiver="service",
        sent_at_s=team.clock.now_s(),
        in_reply_to=f"{script}:pause:1",
        body=Acknowledgement(script_id=script),
    )
    assert service.reports.record(late, "sample_store") is Reception.RECORDED
    assert script_of(api, mission)["order"] == "resume"
    team.faults.silent.clear()
    until(lambda: script_of(api, mission)["order"] is None)
    assert team.robots["store_2"].state is ScriptState.RUNNING
