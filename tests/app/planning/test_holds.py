"""Places that are kept empty until a time, the end of a mission or goal, a fact, or an operator's word."""

from collections.abc import Callable
from typing import Any

import httpx2
import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
HOLDS = "/v1/worlds/sample_store/holds"
NOTICE = "keep bay_7 empty until further notice"


def state(api: TestClient, text: str, **more: Any) -> dict[str, Any]:
    answer = api.post("/v1/goals", json={"text": text, **more})
    assert answer.status_code == 202, answer.text
    body: dict[str, Any] = answer.json()
    return body


def refusal(api: TestClient, **goal: Any) -> dict[str, Any]:
    answer = api.post("/v1/goals", json=goal)
    assert answer.status_code in (409, 422), answer.text
    return refused(answer)


def refused(answer: httpx2.Response) -> dict[str, Any]:
    """A problem, with the code that its type ends with."""
    body: dict[str, Any] = answer.json()
    return {**body, "code": body["type"].rpartition(":")[2]}


def standing(api: TestClient) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = api.get(HOLDS).raise_for_status().json()["items"]
    return found


def ended(api: TestClient) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = api.get(HOLDS, params={"state": "ended"}).json()["items"]
    return found


def end(api: TestClient, comment: str = "") -> dict[str, Any]:
    """End the only hold that stands."""
    (hold,) = standing(api)
    answer: dict[str, Any] = (
        api.post(f"{HOLDS}/{hold['id']}:end", json={"comment": comment}).raise_for_status().json()
    )
    return answer


def approve(api: TestClient, plan_id: str) -> str:
    answer = api.post(f"/v1/plans/{plan_id}:approve", json={}).raise_for_status()
    mission: str = answer.json()["mission_id"]
    return mission


def correct(api: TestClient, predicate: str, *args: str) -> None:
    body = {"facts": [{"predicate": predicate, "args": args}]}
    api.put("/v1/worlds/sample_store/facts", json=body).raise_for_status()


@ON_BOTH
def test_keeping_an_empty_place_empty_is_done_at_once_and_stands(api: TestClient, service: Service) -> None:
    goal = state(api, "keep bay_7 and bay_8 empty for ten minutes")
    assert (goal["state"], goal["outcome"], goal["goal"]) == ("finished", "completed", [])
    assert (
        goal["reason"] == "nothing to carry out; holds bay_7 and bay_8 empty for 10 min of the world's clock"
    )
    (hold,) = standing(api)
    assert (hold["places"], hold["state"], hold["goal_id"]) == (["bay_7", "bay_8"], "held", goal["id"])
    kept = {"places": ["bay_7", "bay_8"], "facts": []}
    assert goal["holds"] == [{"id": hold["id"], **kept, "until": hold["until"]}]
    began = [event for event in service.events.since(0) if event.type == "hold.began"]
    assert [(event.subject, event.data["places"]) for event in began] == [(hold["id"], ["bay_7", "bay_8"])]
    over = end(api, "the delivery came early")
    assert (over["state"], over["ending"], over["ended_by"]) == ("ended", "operator", "administrator")
    assert standing(api) == []
    assert [one["comment"] for one in ended(api)] == ["the delivery came early"]
    last = service.events.since(0)[-1]
    assert (last.type, last.data["why"]) == ("hold.ended", "operator")


def test_ending_a_hold_again_changes_nothing_and_one_of_another_world_is_unknown(
    api: TestClient, service: Service
) -> None:
    state(api, NOTICE)
    hold = end(api)
    count = len(service.events.since(0))
    again = api.post(f"{HOLDS}/{hold['id']}:end", json={"comment": "again"})
    assert (again.status_code, again.json()) == (200, hold)
    assert len(service.events.since(0)) == count
    unknown = api.post(f"{HOLDS}/hold-1:end")
    assert (unknown.status_code, refused(unknown)["code"]) == (404, "unknown-hold")
    assert api.get("/v1/worlds/nowhere/holds").status_code == 404


def test_a_goal_for_a_held_place_is_told_of_the_hold_its_end_and_how_to_end_it(api: TestClient) -> None:
    state(api, NOTICE)
    (hold,) = standing(api)
    told = refusal(api, text="move sample_1 to bay_7")
    assert (told["status"], told["code"], told["thing"]) == (409, "place-held", "bay_7")
    assert f"hold {hold['id']} keeps bay_7 empty until an operator ends it" in told["detail"]
    assert f"POST {HOLDS}/{hold['id']}:end" in told["detail"]
    assert "bay_7" not in told["choices"]
    assert "bay_8" in told["choices"]
    checked = api.post("/v1/goals:check", json={"text": "move sample_1 to bay_7"}).json()
    assert checked["issue"]["code"] == "place-held"
    end(api)
    state(api, "move sample_1 to bay_7")


def test_any_bay_is_none_that_is_held(api: TestClient) -> None:
    assert state(api, "move sample_1 to any bay")["goal"][0]["args"] == ["sample_1", "bay_1"]
    state(api, "keep bay_1 empty until further notice")
    assert state(api, "move sample_1 to any bay")["goal"][0]["args"] == ["sample_1", "bay_3"]


def test_a_goal_that_is_stated_before_the_hold_waits_for_its_end_and_then_proceeds(
    api: TestClient, follow: Follow
) -> None:
    earlier = f"/v1/goals/{state(api, 'move sample_1 to bay_7')['id']}"
    plan = follow(earlier, "planned")["plan_id"]
    state(api, NOTICE)
    (hold,) = standing(api)
    why = f"hold {hold['id']} keeps bay_7 empty until an operator ends it"
    assert why in api.get(f"/v1/plans/{plan}").json()["overtaken"]
    stale = api.post(f"/v1/plans/{plan}:approve", json={})
    assert (stale.status_code, refused(stale)["code"]) == (409, "plan-stale")
    waiting = follow(earlier, "waiting")
    kept = "which keeps bay_7 empty until an operator ends it"
    assert waiting["reason"] == f"waits for the end of hold {hold['id']}, {kept}"
    end(api)
    approve(api, follow(earlier, "planned")["plan_id"])


def test_what_lies_in_the_place_is_moved_elsewhere_and_nothing_new_is_put_there_meanwhile(
    api: TestClient, follow: Follow
) -> None:
    goal = state(api, "keep bay_2 empty until further notice")
    assert [(one["predicate"], *one["args"]) for one in goal["goal"]] == [("in", "sample_2", "bay_1")]
    assert {"said": "bay_2 is emptied", "means": ["sample_2 to bay_1"]} in goal["readings"]
    assert [hold["places"] for hold in standing(api)] == [["bay_2"]]
    assert refusal(api, text="move sample_1 to bay_2")["code"] in ("place-held", "place-occupied")
    mission = approve(api, follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"])
    follow(f"/v1/missions/{mission}", "completed")
    assert refusal(api, text="move sample_1 to bay_2")["code"] == "place-held"


def test_what_the_goal_moves_itself_is_not_moved_twice(api: TestClient) -> None:
    goal = state(api, "keep bay_2 empty until further notice and move sample_2 to bay_7")
    assert [(one["predicate"], *one["args"]) for one in goal["goal"]] == [("in", "sample_2", "bay_7")]


def test_a_hold_on_what_a_running_mission_fills_is_refused_with_the_mission(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_2")
    goal = f"/v1/goals/{state(api, 'move sample_1 to bay_7')['id']}"
    mission = approve(api, follow(goal, "planned")["plan_id"])
    told = refusal(api, text=NOTICE)
    assert (told["code"], told["thing"]) == ("needed-by-mission", "bay_7")
    assert f"mission {mission} puts a sample in bay_7" in told["detail"]
    assert standing(api) == []
    state(api, "keep bay_8 empty until further notice")
    team.faults.stuck.clear()
    follow(f"/v1/missions/{mission}", "completed")


@ON_BOTH
def test_a_hold_ends_with_its_mission(api: TestClient, follow: Follow, team: FakeTeam) -> None:
    team.faults.stuck.add("store_2")
    goal = f"/v1/goals/{state(api, 'move sample_1 to bay_7')['id']}"
    mission = approve(api, follow(goal, "planned")["plan_id"])
    state(api, f"keep bay_8 empty until {mission} has ended")
    waiting = refusal(api, text="move sample_4 to bay_8")
    assert f"until mission {mission} has ended" in waiting["detail"]
    team.faults.stuck.clear()
    follow(f"/v1/missions/{mission}", "completed")
    until(lambda: [one["ending"] for one in ended(api)] == ["mission"])
    state(api, "move sample_4 to bay_8")


def test_a_hold_ends_once_its_goal_is_over(api: TestClient, follow: Follow) -> None:
    goal = state(api, "move sample_1 to bay_7")["id"]
    state(api, f"keep bay_8 empty until goal {goal} is over")
    assert standing(api)[0]["until"] == {**dict.fromkeys(("at", "in_s", "mission", "fact")), "goal": goal}
    api.post(f"/v1/goals/{goal}:cancel").raise_for_status()
    until(lambda: [one["ending"] for one in ended(api)] == ["goal"])


def test_a_hold_ends_once_its_fact_is_true_and_the_goal_that_waits_for_it_is_planned(
    api: TestClient, follow: Follow
) -> None:
    goal = f"/v1/goals/{state(api, 'move sample_1 to bay_7')['id']}"
    plan = follow(goal, "planned")["plan_id"]
    state(api, "keep bay_7 empty until sample_4 is in door_2")
    assert api.post(f"/v1/plans/{plan}:approve", json={}).status_code == 409
    assert "until in(sample_4, door_2)" in follow(goal, "waiting")["reason"]
    correct(api, "in", "sample_4", "door_2")
    follow(goal, "planned")
    assert [one["ending"] for one in ended(api)] == ["fact"]
    assert refusal(api, text="keep bay_8 empty until sample_4 is in door_2")["code"] == "hold-over"


def test_a_hold_for_a_span_ends_by_the_clock_of_the_world(api: TestClient, team: FakeTeam) -> None:
    state(api, "keep bay_7 empty for two hours")
    assert standing(api)
    team.clock.advance(7200.0)
    until(lambda: [one["ending"] for one in ended(api)] == ["time"])


def test_holds_are_stated_beside_facts_and_alone(api: TestClient, follow: Follow) -> None:
    hold = {"places": ["bay_8"], "until": {"in_s": 600}}
    alone = api.post("/v1/goals", json={"holds": [hold]}, headers={"idempotency-key": "k1"})
    assert (alone.status_code, alone.json()["state"]) == (202, "finished"), alone.text
    assert alone.json()["text"] == "keep bay_8 empty for 10 min of the world's clock"
    again = api.post("/v1/goals", json={"holds": [hold]}, headers={"idempotency-key": "k1"})
    assert again.json()["id"] == alone.json()["id"]
    other = {"places": ["bay_9"], "until": {"in_s": 600}}
    reused = api.post("/v1/goals", json={"holds": [other]}, headers={"idempotency-key": "k1"})
    assert refused(reused)["code"] == "idempotency-key-reused"
    assert len(standing(api)) == 1
    fact = {"predicate": "in", "args": ["sample_1", "bay_7"]}
    occupied = {"places": ["bay_2"]}
    body = {"goal": [fact], "holds": [occupied]}
    beside = api.post("/v1/goals", json=body, headers={"idempotency-key": "k2"}).json()
    assert [one["args"][0] for one in beside["goal"]] == ["sample_1", "sample_2"]
    follow(f"/v1/goals/{beside['id']}", "planned")
    assert api.post("/v1/goals", json=body, headers={"idempotency-key": "k2"}).json()["id"] == beside["id"]


@pytest.mark.parametrize(
    ("holds", "code"),
    [
        ([{"places": ["bay_77"]}], "unknown-place"),
        ([{"places": ["bay_7"], "until": {"at": "2020-01-01T00:00:00Z"}}], "hold-over"),
        ([{"places": ["bay_7"], "until": {"mission": "mission-1"}}], "unknown-mission"),
        ([{"places": ["bay_7"], "until": {"goal": "goal-1"}}], "unknown-goal"),
        ([{"places": ["bay_7"], "until": {"fact": {"predicate": "lies"}}}], "malformed-fact"),
        (
            [{"places": ["bay_7"], "until": {"fact": {"predicate": "in", "args": ["x", "y"]}}}],
            "malformed-fact",
        ),
        ([{"places": []}], "malformed-request"),
        ([{"places": ["bay_7"], "until": {"in_s": 5, "goal": "goal-1"}}], "malformed-request"),
        ([{"places": ["bay_7"], "until": {"in_s": 0}}], "malformed-request"),
        ([{"places": ["bay_7"], "until": {"in_s": 1e308}}], "hold-too-long"),
        ([{"places": ["bay_7"], "until": {"at": "2030-01-01T00:00:00"}}], "malformed-request"),
    ],
)
def test_a_hold_that_cannot_be_is_refused(api: TestClient, holds: list[Any], code: str) -> None:
    assert refusal(api, holds=holds)["code"] == code
    assert standing(api) == []


def test_a_goal_that_fills_what_it_keeps_empty_is_refused(api: TestClient) -> None:
    told = refusal(api, text="move sample_1 to bay_7 and keep bay_7 empty for an hour")
    assert (told["code"], told["thing"]) == ("constraint-contradicts-goal", "bay_7")
    assert standing(api) == []


def test_a_check_shows_the_hold_and_makes_none(api: TestClient) -> None:
    text = "keep bay_7 empty until 14:30"
    checked = api.post("/v1/goals:check", json={"text": text}).json()
    assert (checked["issue"], checked["goals"]) == (None, [])
    (shown,) = checked["holds"]
    assert shown["places"] == ["bay_7"]
    assert shown["words"].startswith("will hold bay_7 empty until ")
    assert " (in " in shown["words"]
    assert standing(api) == []
