"""The main job through HTTP alone: goal, plan, decision, mission, facts."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.events_told import told_and_recorded
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import until

pytestmark = ON_BOTH

Follow = Callable[..., dict[str, Any]]
GOAL = {"world": "sample_store", "text": "move sample_1 to bay_7"}


def planned(api: TestClient, follow: Follow, **goal: Any) -> dict[str, Any]:
    answer = api.post("/v1/goals", json=goal or GOAL)
    assert answer.status_code == 202, answer.text
    return follow(f"/v1/goals/{answer.json()['id']}", "planned", "unsolvable")


def approved(api: TestClient, follow: Follow, **goal: Any) -> dict[str, Any]:
    """The mission of a goal that is planned and approved."""
    answer = api.post(f"/v1/plans/{planned(api, follow, **goal)['plan_id']}:approve", json={})
    assert answer.status_code == 202, answer.text
    return api.get(f"/v1/missions/{answer.json()['mission_id']}").json()


def facts(api: TestClient) -> set[str]:
    items = api.get("/v1/worlds/sample_store/facts").json()["items"]
    return {f"{fact['predicate']}({', '.join(fact['args'])})" for fact in items}


def test_a_goal_is_planned_rejected_stated_again_approved_and_completed(
    api: TestClient, follow: Follow
) -> None:
    first = planned(api, follow)
    plan = api.get(f"/v1/plans/{first['plan_id']}").json()
    assert {"yard_1", "yard_2"} & set(plan["robots"])
    assert "store_2" in plan["robots"]
    assert plan["causal_links"]

    rejected = api.post(f"/v1/plans/{plan['id']}:reject", json={"comment": "not before lunch"})
    assert (rejected.status_code, rejected.json()["state"]) == (202, "rejected")
    withdrawn = api.get(f"/v1/goals/{first['id']}").json()
    assert withdrawn["state"] == "withdrawn"
    assert "not before lunch" in withdrawn["reason"]

    mission = approved(api, follow)
    assert mission["estimate_s"] == mission["original_estimate_s"] == plan["makespan_s"]
    ended = follow(f"/v1/missions/{mission['id']}", "completed", "failed", "partially_completed")
    assert ended["state"] == "completed", ended
    assert all(packet["state"] == "finished" for script in ended["progress"] for packet in script["packets"])
    goal = api.get(f"/v1/goals/{ended['goal_id']}").json()
    assert (goal["state"], goal["outcome"]) == ("finished", "completed")
    assert "in(sample_1, bay_7)" in facts(api)
    assert "in(sample_1, door_1)" not in facts(api)


def test_every_robot_gets_one_script_coupled_only_by_what_it_senses(api: TestClient, follow: Follow) -> None:
    mission = approved(api, follow)
    follow(f"/v1/missions/{mission['id']}", "running", "completed")
    scripts = api.get(f"/v1/missions/{mission['id']}/scripts").json()["items"]
    robots = [script["robot"] for script in scripts]
    assert len(robots) == len(set(robots)) == 2
    awaited = {
        f"{fact['predicate']}({', '.join(fact['args'])})"
        for script in scripts
        for packet in script["script"]["packets"]
        for fact in packet["awaits"]
    }
    assert awaited == {"in(sample_1, interchange_2)"}


def test_approving_a_plan_twice_yields_one_mission(api: TestClient, follow: Follow) -> None:
    plan_id = planned(api, follow)["plan_id"]
    first = api.post(f"/v1/plans/{plan_id}:approve", json={}).json()["mission_id"]
    second = api.post(f"/v1/plans/{plan_id}:approve", json={}).json()["mission_id"]
    assert first == second
    assert len(api.get("/v1/missions").json()["items"]) == 1


def test_a_plan_that_the_world_has_overtaken_expires_and_a_fresh_one_is_made(
    api: TestClient, follow: Follow
) -> None:
    goal = planned(api, follow)
    correction = {
        "facts": [{"predicate": "in", "args": ["sample_1", "door_2"]}],
        "comment": "seen on the camera",
    }
    assert api.put("/v1/worlds/sample_store/facts", json=correction).status_code == 200
    refused = api.post(f"/v1/plans/{goal['plan_id']}:approve", json={})
    assert refused.status_code == 409
    assert "in(sample_1, door_1)" in refused.json()["detail"]
    assert api.get(f"/v1/plans/{goal['plan_id']}").json()["state"] == "expired"
    again = follow(f"/v1/goals/{goal['id']}", "planned")
    assert again["plan_id"] != goal["plan_id"]
    assert api.post(f"/v1/plans/{again['plan_id']}:approve", json={}).status_code == 202


def test_a_second_goal_that_needs_the_same_robots_waits_with_a_reason(
    api: TestClient, follow: Follow
) -> None:
    mission = approved(api, follow)
    answer = api.post("/v1/goals", json={"text": "move sample_4 to bay_8", "auto_approve": True}).json()
    goal = follow(f"/v1/goals/{answer['id']}", "waiting", "committed", "finished", "unsolvable")
    if goal["state"] == "waiting":
        assert mission["id"] in goal["reason"]
    ended = follow(f"/v1/goals/{answer['id']}", "finished", "unsolvable")
    assert ended["outcome"] == "completed", ended
    assert {"in(sample_1, bay_7)", "in(sample_4, bay_8)"} <= facts(api)


def test_goals_that_share_nothing_run_side_by_side(api: TestClient, follow: Follow) -> None:
    first = approved(api, follow, text="move sample_2 to bay_4")
    second = approved(api, follow, text="move sample_4 to bay_8")
    assert set(first["id"]) != set(second["id"])
    for mission in (first, second):
        assert follow(f"/v1/missions/{mission['id']}", "completed", "failed")["state"] == "completed"


def test_a_goal_with_auto_approve_needs_nobody(api: TestClient, follow: Follow) -> None:
    answer = api.post("/v1/goals", json={**GOAL, "auto_approve": True}).json()
    assert follow(f"/v1/goals/{answer['id']}", "finished")["outcome"] == "completed"
    plan = api.get("/v1/plans").json()["items"][0]
    assert (plan["state"], plan["decided_by"]) == ("approved", "auto_approve")


def test_a_goal_that_is_true_already_ends_without_a_plan(
    api: TestClient, follow: Follow, service: Service
) -> None:
    for allocation in ("central", "contract_net"):
        answer = api.post("/v1/goals", json={"text": "move sample_1 to door_1", "allocation": allocation})
        assert answer.status_code == 202, answer.text
        goal = follow(f"/v1/goals/{answer.json()['id']}", "finished")
        assert (goal["outcome"], goal["reason"]) == ("completed", "nothing to carry out; it is true already")
        assert (goal["plan_id"], goal["mission_id"]) == (None, None)
    told, recorded = told_and_recorded(service.database)
    assert told == recorded


def test_reports_that_arrive_twice_count_once(api: TestClient, follow: Follow, team: FakeTeam) -> None:
    team.faults.repeats = True
    mission = approved(api, follow)
    follow(f"/v1/missions/{mission['id']}", "completed")
    events = api.get("/v1/missions/" + mission["id"]).json()
    assert events["state"] == "completed"
    for robot in team.robots.values():
        assert len(robot.executed) == len(set(robot.executed))


def test_events_tell_the_state_of_every_goal_plan_and_mission(
    api: TestClient, service: Service, follow: Follow
) -> None:
    goal = api.post("/v1/goals", json={**GOAL, "auto_approve": True}).json()

    def is_finished() -> bool:
        told, recorded = told_and_recorded(service.database)
        assert told == recorded
        return recorded.get(goal["id"]) == "finished"

    until(is_finished)
    events = [event for event in service.events.since(0) if event.subject == goal["id"]]
    states = [event.data["state"] for event in events]
    assert list(dict.fromkeys(states)) == ["submitted", "planning", "planned", "committed", "finished"]


def test_facts_in_events_are_written_as_the_api_has_them(
    api: TestClient, service: Service, follow: Follow
) -> None:
    mission = approved(api, follow)
    follow(f"/v1/missions/{mission['id']}", "completed", "failed", "partially_completed")
    begun, *changes = [e.data for e in service.events.since(0) if e.type == "world.facts_changed"]
    believed = set(begun["added"])
    for change in changes:
        assert set(change["removed"]) <= believed
        believed = believed - set(change["removed"]) | set(change["added"])
    assert believed == facts(api)
