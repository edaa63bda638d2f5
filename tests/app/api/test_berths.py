"""A location with several berths over HTTP: goals, facts and layout."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from robots.world import WorldFile
from tests.app.berthed_store import berthed_store

Follow = Callable[..., dict[str, Any]]
WORLD = "/v1/worlds/sample_store"


@pytest.fixture
def world_file() -> WorldFile:
    return berthed_store()


def planned(api: TestClient, follow: Follow, text: str) -> dict[str, Any]:
    answer = api.post("/v1/goals", json={"text": text})
    assert answer.status_code == 202, answer.text
    return follow(f"/v1/goals/{answer.json()['id']}", "planned", "unsolvable")


def aims(api: TestClient, goal: dict[str, Any]) -> list[list[str]]:
    return [fact["args"] for fact in api.get(f"/v1/plans/{goal['plan_id']}").json()["goals"]]


def approved(api: TestClient, follow: Follow, goal: dict[str, Any]) -> str:
    """The goal's mission; a plan that another mission overtook is repaired first."""
    answer = api.post(f"/v1/plans/{goal['plan_id']}:approve", json={})
    if answer.status_code == 409:
        again = follow(f"/v1/goals/{goal['id']}", "planned")
        answer = api.post(f"/v1/plans/{again['plan_id']}:approve", json={})
    return str(answer.json()["mission_id"])


def lying(api: TestClient) -> dict[str, str]:
    facts = api.get(f"{WORLD}/facts").json()["items"]
    return {fact["args"][0]: fact["args"][1] for fact in facts if fact["predicate"] == "in"}


def correct(api: TestClient, *args: str) -> Any:
    return api.put(f"{WORLD}/facts", json={"facts": [{"predicate": "in", "args": args, "value": True}]})


def test_goals_stated_one_after_the_other_get_a_berth_each_and_both_come_true(
    api: TestClient, follow: Follow
) -> None:
    one = planned(api, follow, "move sample_1 to bay_7")
    other = planned(api, follow, "move sample_3 to bay_7")
    assert one["goal"] == [{"predicate": "in", "args": ["sample_1", "bay_7"]}]
    assert aims(api, one) == [["sample_1", "bay_7_1"]]
    assert aims(api, other) == [["sample_3", "bay_7_2"]]
    for goal in (one, other):
        mission = approved(api, follow, goal)
        follow(f"/v1/missions/{mission}", "completed")
    assert {"sample_1": "bay_7_1", "sample_3": "bay_7_2"}.items() <= lying(api).items()


def test_a_plan_that_is_repaired_keeps_its_berth(api: TestClient, follow: Follow) -> None:
    first = planned(api, follow, "move sample_1 to bay_7")
    planned(api, follow, "move sample_3 to bay_7")
    assert correct(api, "sample_1", "door_2").status_code == 200
    assert api.post(f"/v1/plans/{first['plan_id']}:approve", json={}).status_code == 409
    again = follow(f"/v1/goals/{first['id']}", "planned")
    assert again["plan_id"] != first["plan_id"]
    assert aims(api, again) == [["sample_1", "bay_7_1"]]


def test_facts_and_goals_fill_the_berths_until_there_is_no_room(api: TestClient) -> None:
    for number, sample in enumerate(("sample_2", "sample_3", "sample_4"), start=1):
        assert correct(api, sample, "bay_7").status_code == 200
        assert lying(api)[sample] == f"bay_7_{number}"
    full = correct(api, "sample_1", "bay_7")
    assert (full.status_code, full.json()["type"]) == (409, "urn:macta:problem:place-occupied")
    refused = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"})
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:place-occupied")
    assert "its 3 berths are occupied by sample_2, sample_3 and sample_4" in refused.json()["detail"]


def test_the_layout_tells_the_berths(api: TestClient) -> None:
    layout = api.get(WORLD).json()["layout"]
    racks = {rack["name"]: rack for rack in layout["racks"]}
    assert (racks["bay_7"]["capacity"], racks["bay_7"]["berths"]) == (3, ["bay_7_1", "bay_7_2", "bay_7_3"])
    assert {"bay_7_1", "bay_2_2"} <= {place["name"] for place in layout["locations"]}
