"""Operators' orders that come at once while a repair waits for a decision: one is carried out after the other."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.databases import ON_BOTH
from tests.waiting import ENDED, read_until

pytestmark = ON_BOTH
FACTS = "/v1/worlds/sample_store/facts"
ELSEWHERE = {"facts": [{"predicate": "in", "args": ["sample_2", "bay_3"]}]}


@pytest.fixture
def deciding(api: TestClient, start: Start) -> dict[str, Any]:
    """A mission whose repaired plan waits for a decision."""
    path, _ = start("ask", fails="DOCK")
    mission: dict[str, Any] = read_until(api, path, lambda now: now["recovery"]["step"] == "deciding")
    return mission


def all_at_once(*orders: Callable[[], Any]) -> list[int]:
    """The status of each order's answer."""
    with ThreadPoolExecutor(len(orders)) as pool:
        return [order.result(timeout=60).status_code for order in [pool.submit(order) for order in orders]]


def test_a_repair_that_is_approved_and_whose_mission_is_cancelled_at_once_ends_as_one_of_both(
    api: TestClient, deciding: dict[str, Any], follow: Follow, team: FakeTeam
) -> None:
    path = f"/v1/missions/{deciding['id']}"
    plan = f"/v1/plans/{deciding['recovery']['attempts'][-1]['plan_id']}"
    lost = next(script["robot"] for script in deciding["progress"] if script["state"] == "failed")
    team.faults.stuck |= {
        "yard_1",
        "yard_2",
        "store_1",
        "store_2",
    }  # or the mission may end before it is cancelled
    said = all_at_once(
        lambda: api.post(f"{plan}:approve"),
        lambda: api.post(f"{path}:cancel"),
        lambda: api.post(f"/v1/robots/{lost}:declare_lost"),
        lambda: api.put(FACTS, json=ELSEWHERE),
        lambda: api.put(f"{path}/recovery", json={"policy": "auto"}),
    )
    assert set(said) <= {200, 202, 409}, said
    assert said[1] == 202
    ended = follow(path, *ENDED)
    assert ended["state"] == "cancelled"
    assert api.get(f"/v1/goals/{ended['goal_id']}").json()["outcome"] == "cancelled"
    assert api.get(plan).json()["state"] in ("approved", "expired")


def test_of_one_who_approves_and_one_who_rejects_at_once_exactly_one_is_heard(
    api: TestClient, deciding: dict[str, Any], follow: Follow, team: FakeTeam
) -> None:
    plan = f"/v1/plans/{deciding['recovery']['attempts'][-1]['plan_id']}"
    approved, rejected = all_at_once(
        lambda: api.post(f"{plan}:approve"), lambda: api.post(f"{plan}:reject", json={"comment": "no"})
    )
    assert sorted([approved, rejected]) == [202, 409]
    ended = follow(f"/v1/missions/{deciding['id']}", *ENDED)
    assert ended["state"] == ("completed" if approved == 202 else "failed"), ended["reason"]
