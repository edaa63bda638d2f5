"""Texts that a database does not record: robots' are mended, clients' are refused."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH

Follow = Callable[..., dict[str, Any]]


@ON_BOTH
def test_a_nul_in_a_robots_report_is_recorded_as_a_replacement(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.fails_at["yard_1"] = "DOCK"
    team.faults.says = "jaw\0stuck"
    body = {"text": "move sample_1 to bay_7 without yard_2", "recovery": "never"}
    goal = api.post("/v1/goals", json=body).raise_for_status().json()["id"]
    plan = follow(f"/v1/goals/{goal}", "planned", "unsolvable")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    ended = follow(f"/v1/missions/{mission}", "failed", "partially_completed")
    assert "jaw\N{REPLACEMENT CHARACTER}stuck" in str(ended)


@pytest.mark.parametrize("slot", ["text", "constraints.robots.0"])
def test_a_nul_of_a_client_is_refused_with_its_field(api: TestClient, slot: str) -> None:
    body = {"text": "park yard_1"} | (
        {"text": "park\0"} if slot == "text" else {"constraints": {"robots": ["a\0"]}}
    )
    answer = api.post("/v1/goals", json=body)
    assert answer.status_code == 422
    assert [error["slot"] for error in answer.json()["errors"]] == [f"body.{slot}"]
    assert "NUL" in answer.text.upper()
