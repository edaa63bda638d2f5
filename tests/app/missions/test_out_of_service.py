"""Robots that operators take out of service are not recruited until they are brought back."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
NEEDS_STORE_2 = "move sample_1 to bay_7"
REASON = "its left wheel slips"


def take_out(api: TestClient, *robots: str) -> None:
    body = {"robots": robots, "reason": REASON}
    api.post("/v1/robots:take_out_of_service", json=body).raise_for_status()


def resting(api: TestClient) -> list[str]:
    return [one["id"] for one in api.get("/v1/robots").json()["items"] if one["out_of_service"]]


def stated(api: TestClient) -> str:
    goal = api.post("/v1/goals", json={"text": NEEDS_STORE_2}).raise_for_status().json()["id"]
    return f"/v1/goals/{goal}"


@ON_BOTH
def test_a_goal_waits_for_a_robot_that_is_out_of_service_and_is_planned_once_it_is_back(
    api: TestClient, follow: Follow
) -> None:
    taken = api.post("/v1/robots/store_2:take_out_of_service", json={"reason": REASON})
    assert taken.status_code == 200, taken.text
    assert taken.json()["out_of_service"]["reason"] == REASON
    assert taken.json()["out_of_service"]["taken_by"] == "administrator"
    goal = stated(api)
    waiting = follow(goal, "waiting")
    assert waiting["reason"] == f"waits for store_2, which administrator took out of service: {REASON}"
    back = api.post("/v1/robots/store_2:bring_back", json={"comment": "mended"})
    assert (back.status_code, back.json()["out_of_service"]) == (200, None)
    follow(goal, "planned")


def test_a_goal_that_waits_says_the_new_reason(api: TestClient, follow: Follow) -> None:
    take_out(api, "store_2")
    goal = stated(api)
    follow(goal, "waiting")
    api.post("/v1/robots/store_2:take_out_of_service", json={"reason": "being painted"}).raise_for_status()
    until(lambda: api.get(goal).json()["reason"].endswith("being painted"))


def test_a_plan_that_uses_a_robot_out_of_service_is_out_of_date(api: TestClient, follow: Follow) -> None:
    plan = follow(stated(api), "planned")["plan_id"]
    take_out(api, "store_2")
    refused = api.post(f"/v1/plans/{plan}:approve", json={})
    assert refused.status_code == 409
    assert f"store_2 was taken out of service: {REASON}" in refused.json()["detail"]


def test_a_robot_that_is_taken_out_of_service_ends_what_it_has_begun(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_2")
    plan = follow(stated(api), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    follow(f"/v1/missions/{mission}", "running")
    take_out(api, "store_2")
    team.faults.stuck.clear()
    assert follow(f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
    assert resting(api) == ["store_2"]


def test_a_group_is_taken_out_and_brought_back_all_or_none(api: TestClient, service: Service) -> None:
    body = {"robots": ["yard_1", "nobody"], "reason": REASON}
    unknown = api.post("/v1/robots:take_out_of_service", json=body)
    assert (unknown.status_code, resting(api)) == (404, [])
    assert "nobody" in unknown.json()["detail"]
    assert "yard_2" in unknown.json()["choices"]
    take_out(api, "yard_2", "yard_1", "yard_1")
    assert resting(api) == ["yard_1", "yard_2"]
    refused = api.post("/v1/robots:bring_back", json={"robots": ["yard_1", "store_1"]})
    assert (refused.status_code, resting(api)) == (409, ["yard_1", "yard_2"])
    assert refused.json()["detail"] == "store_1 is not out of service"
    back = api.post("/v1/robots:bring_back", json={"robots": ["yard_1", "yard_2"]})
    assert [one["id"] for one in back.json()["items"]] == ["yard_1", "yard_2"]
    assert resting(api) == []
    types = [event.type for event in service.events.since(0)]
    assert types.count("robot.taken_out_of_service") == types.count("robot.brought_back") == 2


def test_a_robot_is_not_taken_out_of_service_without_a_reason(api: TestClient) -> None:
    for body in ({}, {"reason": ""}, {"reason": "x" * 2001}):
        refused = api.post("/v1/robots/store_2:take_out_of_service", json=body)
        assert (refused.status_code, refused.json()["errors"][0]["slot"]) == (422, "body.reason")
    assert resting(api) == []
