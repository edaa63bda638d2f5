"""Constraints, sets and times of goals through HTTP: shown before planning, kept by the plan, alike in both forms."""

from datetime import datetime
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.app.api.test_main_job import Follow, approved, planned
from tests.app.fake_robots import FakeTeam


def facts_of(body: dict[str, Any]) -> list[str]:
    return [f"{goal['predicate']}({', '.join(goal['args'])})" for goal in body["goal"]]


def plan_of(api: TestClient, goal: dict[str, Any]) -> dict[str, Any]:
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


def test_a_sentence_is_shown_resolved_and_its_plan_keeps_the_constraints(
    api: TestClient, follow: Follow
) -> None:
    text = "move sample_1 to bay_7 with yard_2 and store_2 in ten minutes"
    goal = planned(api, follow, text=text)
    assert facts_of(goal) == ["in(sample_1, bay_7)"]
    assert goal["constraints"]["robots"] == ["yard_2", "store_2"]
    assert (goal["deadline_s"], goal["due"]) == (600, {"in_s": 600, "at": None, "mission": None})
    assert goal["readings"] == [{"said": "in ten minutes", "means": ["in 600 s of the world's clock"]}]
    assert plan_of(api, goal)["robots"] == ["store_2", "yard_2"]


def test_the_structured_form_says_the_same(api: TestClient, follow: Follow) -> None:
    stated = {
        "goal": [{"predicate": "in", "args": ["sample_1", "bay_7"]}],
        "constraints": {"robots": ["yard_2", "store_2"]},
        "deadline_s": 600,
    }
    goal = planned(api, follow, **stated)
    assert goal["constraints"]["robots"] == ["yard_2", "store_2"]
    assert plan_of(api, goal)["robots"] == ["store_2", "yard_2"]


def test_goals_in_stages_are_carried_out_one_after_the_other(api: TestClient, follow: Follow) -> None:
    mission = approved(api, follow, text="send yard_2 to door_2, then send store_1 to bay_1")
    ended = follow(f"/v1/missions/{mission['id']}", "completed", "failed", "partially_completed")
    assert ended["state"] == "completed"
    plan = api.get(f"/v1/plans/{mission['plan_id']}").json()
    assert [(one["reason"], one["kept_by"]) for one in plan["orderings"]] == [("stage", "clearance")]
    packets = {script["robot"]: script["packets"][0] for script in ended["progress"]}
    assert packets["store_1"]["started_at_s"] >= packets["yard_2"]["finished_at_s"]
    why = api.get(f"/v1/plans/{plan['id']}/actions/a2/explanation").json()
    assert "the goal asks for that yard_2 is near door_2 before" in str(why)


def test_before_a_mission_is_resolved_against_the_open_ones(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    refused = api.post("/v1/goals", json={"text": "park yard_1 before mission-1"}).json()
    assert refused["type"].endswith("unknown-mission")
    team.faults.silent.add("store_1")
    mission = approved(api, follow, text="send store_1 to bay_1")
    body = {"text": f"park yard_1 before {mission['id']}"}
    checked = api.post("/v1/goals:check", json=body).json()
    assert checked["issue"] is None
    assert checked["due"]["mission"] == mission["id"]
    assert checked["deadline_s"] == checked["due"]["in_s"] == mission["estimate_s"]


def test_a_goal_after_a_mission_is_planned_once_that_has_ended(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.silent.add("store_1")
    mission = approved(api, follow, text="send store_1 to bay_1")
    structured = {"goal": [{"predicate": "near", "args": ["yard_2", "door_2"]}]}
    for body in (
        {"text": f"move sample_1 to bay_7 after {mission['id']}"},
        {**structured, "constraints": {"after": [mission["id"]]}},
    ):
        goal = api.post("/v1/goals", json={**body, "auto_approve": True}).json()
        waits = follow(f"/v1/goals/{goal['id']}", "waiting", "planned", "committed")
        assert waits["reason"] == f"waits for the end of mission {mission['id']}"
    team.faults.silent.clear()
    done = follow(f"/v1/goals/{goal['id']}", "finished", "unsolvable")
    assert done["outcome"] == "completed"
    ended = follow(f"/v1/missions/{mission['id']}", "completed")
    assert api.get(f"/v1/missions/{done['mission_id']}").json()["started_at_s"] >= ended["ended_at_s"]


def test_a_goal_after_a_mission_that_does_not_exist_is_refused(api: TestClient) -> None:
    body = {
        "goal": [{"predicate": "near", "args": ["yard_2", "door_2"]}],
        "constraints": {"after": ["mission-1"]},
    }
    for refused in (
        api.post("/v1/goals", json=body),
        api.post("/v1/goals", json={"text": "park yard_1 after mission-1"}),
    ):
        assert refused.status_code == 422
        assert refused.json()["type"].endswith("unknown-mission")
        assert "'mission-1'" in refused.json()["detail"]
    assert api.post("/v1/goals:check", json=body).json()["issue"]["code"] == "unknown-mission"


def test_the_same_request_again_is_the_same_goal_though_time_has_passed(api: TestClient) -> None:
    body = {"text": "park yard_1 by 23:59 without yard_2", "constraints": {"avoid": ["door_1"]}}
    headers = {"Idempotency-Key": "parked"}
    first = api.post("/v1/goals", json=body, headers=headers)
    again = api.post("/v1/goals", json=body, headers=headers)
    assert (first.status_code, again.status_code) == (202, 202)
    assert first.json()["id"] == again.json()["id"]
    assert datetime.fromisoformat(first.json()["due"]["at"]).strftime("%H:%M") == "23:59"
    other = api.post("/v1/goals", json={**body, "constraints": {}}, headers=headers)
    assert other.json()["type"].endswith("idempotency-key-reused")


@pytest.mark.parametrize(
    ("body", "status", "code", "thing"),
    [
        ({"text": "inspect bay_4"}, 422, "unknown-verb", "inspect"),
        ({"text": "move sample_1 to bay_77"}, 422, "unknown-place", "bay_77"),
        ({"text": "move sample_1 to bay_7 with yard_2"}, 409, "constraints-too-tight", "bay_7"),
        ({"text": "park yard_1", "constraints": {"without": ["yard_9"]}}, 422, "unknown-robot", "yard_9"),
        ({"text": "park yard_1", "constraints": {"stages": [0, 1]}}, 422, "stages-of-other-goals", None),
        ({"text": "park yard_1", "constraints": {"except": ["yard_9"]}}, 422, "malformed-request", None),
        ({"text": "park yard_1 by 23:00", "deadline_s": 5}, 422, "two-deadlines", None),
        (
            {
                "goal": [{"predicate": "near", "args": ["yard_1", "door_1"]}],
                "constraints": {"avoid": ["door_1"]},
            },
            422,
            "constraint-contradicts-goal",
            "door_1",
        ),
    ],
)
def test_what_is_wrong_is_refused_with_the_thing(
    api: TestClient, body: dict[str, Any], status: int, code: str, thing: str | None
) -> None:
    refused = api.post("/v1/goals", json=body)
    assert (refused.status_code, refused.json()["type"]) == (status, f"urn:macta:problem:{code}")
    assert refused.json().get("thing") == thing
    if code == "unknown-place":
        assert refused.json()["span"] == [17, 23]
    assert api.get("/v1/goals").json()["items"] == []


def test_a_structured_goal_is_checked_without_being_recorded(api: TestClient) -> None:
    body = {
        "goal": [{"predicate": "in", "args": ["sample_1", "bay_7"]}],
        "constraints": {"avoid": ["bay_3", "interchange_2"], "without": ["store_1"]},
    }
    checked = api.post("/v1/goals:check", json=body).json()["issue"]
    refused = api.post("/v1/goals", json=body).json()
    assert refused["type"].endswith(checked["code"])
    for told in (checked, refused):
        assert told["constraints"] == ["avoiding interchange_2"]
        assert told["choices"] == ["interchange_2"]
        assert told["detail"].endswith(", avoiding interchange_2")
    assert checked["code"] == "constraints-too-tight"
    assert api.get("/v1/goals").json()["items"] == []


@pytest.mark.parametrize(
    ("text", "code", "word"),
    [
        ("move sample_1 to Bay 2", "place-occupied", "Bay 2"),
        ("move sample_1 to bay_7 without store_2", "constraints-too-tight", "bay_7"),
        ("send yard_1 to door_1 without yard_1", "constraint-contradicts-goal", "yard_1"),
    ],
)
def test_a_refusal_has_its_place_in_the_sentence(api: TestClient, text: str, code: str, word: str) -> None:
    refused = api.post("/v1/goals", json={"text": text}).json()
    assert refused["type"].endswith(code)
    assert text[slice(*refused["span"])] == word
    assert api.post("/v1/goals:check", json={"text": text}).json()["issue"]["span"] == refused["span"]


def test_what_constraints_withhold_is_not_offered_as_a_completion(api: TestClient) -> None:
    text = "move sample_1 to bay_7 without store_2"
    checked = api.post("/v1/goals:check", json={"text": text}).json()
    assert checked["issue"]["choices"] == ["store_2"]
    assert checked["completions"] == []


def test_stages_beside_a_sentence_do_not_contradict_its_order(api: TestClient) -> None:
    text = "send yard_2 to door_2, then park store_1"
    same = {"text": text, "constraints": {"stages": [0, 1]}}
    assert api.post("/v1/goals:check", json=same).json()["issue"] is None
    refused = api.post("/v1/goals", json={"text": text, "constraints": {"stages": [1, 0]}}).json()
    assert refused["type"].endswith("two-orders")
    assert text[slice(*refused["span"])] == "then"


def test_goals_that_leave_their_place_open_get_different_ones(api: TestClient) -> None:
    def place(sample: str) -> str:
        body = {"text": f"move {sample} to any bay"}
        said: str = api.post("/v1/goals", json=body).raise_for_status().json()["goal"][0]["args"][1]
        return said

    assert [place("sample_1"), place("sample_4"), place("sample_1")] == ["bay_1", "bay_3", "bay_1"]


def test_a_free_place_is_chosen_within_the_constraints_beside_the_sentence(api: TestClient) -> None:
    body = {"text": "move sample_1 to any bay", "constraints": {"without": ["store_1"]}}
    checked = api.post("/v1/goals:check", json=body).json()
    assert (checked["goals"][0]["args"], checked["issue"]) == (["sample_1", "bay_7"], None)
