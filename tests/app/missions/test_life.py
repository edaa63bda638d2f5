"""A mission's workflow: reports wake it, and it carries the mission out once, to its end."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import func, select

from app.composition import Service
from app.store import MessageRow, ScriptRow
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH

Follow = Callable[..., dict[str, Any]]


@ON_BOTH
def test_a_mission_is_carried_out_once_by_a_workflow_that_reports_wake(
    service: Service, api: TestClient, follow: Follow, team: FakeTeam, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.missions.life.SHORTEST_SLEEP_S", 20.0)  # it goes on because it is woken
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    mission = follow(f"/v1/goals/{goal['id']}", "committed")["mission_id"]
    assert follow(f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
    with service.database.read() as session:
        scripts = session.scalars(select(ScriptRow).where(ScriptRow.mission_id == mission)).all()
        assert len({script.robot for script in scripts}) == len(scripts)
        ends = session.scalar(
            select(func.count()).select_from(MessageRow).where(MessageRow.kind == "script_report")
        )
    assert ends == len(scripts)


def test_a_goal_that_is_true_already_ends_without_a_mission(api: TestClient, follow: Follow) -> None:
    goal = api.post("/v1/goals", json={"text": "move sample_2 to bay_2", "auto_approve": True}).json()
    ended = follow(f"/v1/goals/{goal['id']}", "finished")
    assert (ended["outcome"], ended["mission_id"]) == ("completed", None)
