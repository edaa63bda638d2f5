"""Durations are learned from missions that were carried out, and plans are made with them."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from robots.world.parts import PHASE_TAGS, STORE_TAGS
from tests.app.fake_robots import FakeTeam
from tests.waiting import read_until

Follow = Callable[..., dict[str, Any]]
Carry = Callable[[str], str]


@pytest.fixture
def plan(api: TestClient, follow: Follow) -> Callable[[str], dict[str, Any]]:
    def planned(text: str) -> dict[str, Any]:
        goal = api.post("/v1/goals", json={"text": text}).json()
        plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
        body: dict[str, Any] = api.get(f"/v1/plans/{plan_id}").json()
        return body

    return planned


@pytest.fixture
def approve(api: TestClient) -> Callable[[dict[str, Any]], str]:
    def approved(plan: dict[str, Any]) -> str:
        answer = api.post(f"/v1/plans/{plan['id']}:approve").json()
        return f"/v1/missions/{answer['mission_id']}"

    return approved


def learned(api: TestClient) -> dict[str, dict[str, Any]]:
    items = api.get("/v1/worlds/sample_store/durations").json()["items"]
    return {item["action"]: item for item in items}


def docks_s(plan: dict[str, Any]) -> set[float]:
    return {action["duration_s"] for action in plan["actions"] if action["tag"] == "DOCK"}


def test_nothing_is_learned_before_a_mission(api: TestClient) -> None:
    assert learned(api) == {}
    assert api.get("/v1/worlds/atlantis/durations").status_code == 404


def test_estimates_come_true_mission_by_mission(
    api: TestClient, follow: Follow, team: FakeTeam, plan: Any, approve: Any
) -> None:
    team.faults.takes_s["DOCK"] = 5.0
    team.faults.repeats = True
    first = plan("move sample_1 to bay_7")
    assert docks_s(first) == {2.5}
    follow(approve(first), "completed")
    docks = [action for action in first["actions"] if action["tag"] == "DOCK"]
    assert learned(api)["DOCK"]["samples"] == len(docks) == 2
    assert learned(api)["DOCK"]["mean"] == pytest.approx(2.0)
    second = plan("move sample_1 to bay_8")
    assert docks_s(second) == {3.5}  # 1.4 times: two samples of 2, drawn towards 1
    follow(approve(second), "completed")
    # The second plan's durations were scaled already; what is learned is still the ratio to the first's.
    assert learned(api)["DOCK"]["samples"] > 2
    assert learned(api)["DOCK"]["mean"] == pytest.approx(2.0, abs=0.02)
    third = plan("move sample_1 to bay_9")
    assert docks_s(second).pop() < docks_s(third).pop() < 5.0


def test_a_mission_that_was_paused_teaches_nothing(
    api: TestClient, follow: Follow, team: FakeTeam, plan: Any, approve: Any
) -> None:
    team.faults.stuck |= {"yard_1", "yard_2", "store_2"}
    mission = approve(plan("move sample_1 to bay_7"))
    read_until(api, mission, lambda now: [s["delivery"] for s in now["progress"]] == ["acknowledged"] * 2)
    api.post(f"{mission}:pause")
    api.post(f"{mission}:resume")
    team.faults.stuck.clear()
    follow(mission, "completed")
    assert learned(api) == {}


def test_an_action_in_phases_teaches_by_all_of_them_together(
    api: TestClient, follow: Follow, team: FakeTeam, plan: Any, approve: Any
) -> None:
    """Its times at start and end are never scaled: the end of one of its phases alone would mislead."""
    edits = [
        {"edit": "change_robot", "name": name, "repertoire": [*STORE_TAGS, *PHASE_TAGS]}
        for name in ("yard_1", "yard_2", "store_2")
    ]
    api.post(
        "/v1/worlds/sample_store/changes", json={"reason": "new packets", "edits": edits}
    ).raise_for_status()
    team.faults.takes_s["TRANSPORT_UP"] = 20.0
    first = plan("move sample_1 to bay_7")
    drives: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for action in first["actions"]:
        if action["tag"] == "TRANSPORT":
            drives.setdefault(tuple(action["arguments"].values()), []).append(action)
    assert {action["phase"] for parts in drives.values() for action in parts} >= {1, 2, 3}
    follow(approve(first), "completed")
    ratios = [
        sum(20.0 if one["phase"] == 2 else one["duration_s"] for one in parts)
        / sum(one["duration_s"] for one in parts)
        for parts in drives.values()
    ]
    assert learned(api)["TRANSPORT"]["samples"] == len(drives)
    assert learned(api)["TRANSPORT"]["mean"] == pytest.approx(sum(ratios) / len(ratios), rel=0.1)
