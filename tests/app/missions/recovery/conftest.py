"""Missions of the sample store under way, with robots that say what they perceive."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.app.fake_robots import FakeTeam

Follow = Callable[..., dict[str, Any]]
Start = Callable[..., tuple[str, str]]


@pytest.fixture
def start(api: TestClient, follow: Follow, team: FakeTeam) -> Start:
    """`start("ask", fails="DOCK")` approves a plan for the main goal; answers the mission's path and its yard robot.

    The yard robot fails at the packet named, as often as `times` says.
    """
    team.faults.perceives = True

    def started(
        policy: str,
        *,
        fails: str | None = None,
        times: int = 1_000,
        text: str = "move sample_1 to bay_7",
        **wishes: Any,
    ) -> tuple[str, str]:
        goal = api.post("/v1/goals", json={"text": text, "recovery": policy, **wishes}).json()
        plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
        robots = api.get(f"/v1/plans/{plan_id}").json()["robots"]
        yard = next(robot for robot in robots if robot.startswith("yard"))
        if fails is not None:
            team.faults.fails_at, team.faults.failures_left = {yard: fails}, times
            # By the plan, another robot's drive ends within half a second of this failure; it is to have ended.
            team.faults.takes_s.setdefault("DOCK", 6.0)
        mission_id = api.post(f"/v1/plans/{plan_id}:approve", json={}).json()["mission_id"]
        return f"/v1/missions/{mission_id}", yard

    return started
