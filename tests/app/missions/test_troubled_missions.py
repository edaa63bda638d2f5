"""Missions that do not go as planned and are not recovered: silence, failure, refusal, cancel, pause, a plan that comes
true only in part.
"""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.fake_robots import FakeTeam
from tests.waiting import ENDED, until

Follow = Callable[..., dict[str, Any]]


@pytest.fixture
def start(api: TestClient, follow: Follow) -> Callable[[], str]:
    """Approves a plan for the main goal; answers the path of its mission."""

    def approved() -> str:
        goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "recovery": "never"}).json()
        plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
        mission_id = api.post(f"/v1/plans/{plan_id}:approve", json={}).json()["mission_id"]
        return f"/v1/missions/{mission_id}"

    return approved


def events(service: Service, type_: str) -> list[dict[str, Any]]:
    return [row.data for row in service.events.since(0) if row.type == type_]


def believed(api: TestClient) -> set[str]:
    items = api.get("/v1/worlds/sample_store/facts").json()["items"]
    return {f"{fact['predicate']}({', '.join(fact['args'])})" for fact in items}


def test_silent_robots_are_asked_and_make_the_mission_unknown_until_they_answer(
    start: Callable[[], str], follow: Follow, team: FakeTeam, service: Service
) -> None:
    team.faults.stuck.add("store_2")
    mission = start()
    follow(mission, "running")
    team.faults.silent.add("store_2")
    unknown = follow(mission, "unknown", *ENDED)
    assert unknown["state"] == "unknown"
    assert unknown["failure"] == "unreachable"
    assert "store_2" in unknown["reason"]
    assert events(service, "mission.robots_asked")
    team.faults.silent.clear()
    team.faults.stuck.clear()
    assert follow(mission, "completed", "failed")["state"] == "completed"


def test_a_robot_that_is_late_but_at_work_extends_the_estimate(
    start: Callable[[], str], follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_2")
    mission = start()
    first = follow(mission, "running")
    while follow(mission, "running")["estimate_s"] == first["original_estimate_s"]:
        pass
    team.faults.stuck.clear()
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed"
    assert ended["estimate_s"] > ended["original_estimate_s"] == first["original_estimate_s"]


def test_when_a_robot_fails_the_others_are_stopped_and_the_facts_say_what_is_known(
    start: Callable[[], str], follow: Follow, team: FakeTeam, api: TestClient
) -> None:
    team.faults.fails_at = dict.fromkeys(("yard_1", "yard_2"), "DOCK")
    mission = start()
    ended = follow(mission, *ENDED)
    assert ended["state"] == "failed"
    assert ended["failure"] == "robot"
    assert "the gripper does not close" in ended["reason"]
    assert {script["state"] for script in ended["progress"]} == {"failed", "cancelled"}
    goal = api.get(f"/v1/goals/{ended['goal_id']}").json()
    assert (goal["state"], goal["outcome"]) == ("finished", "failed")
    assert "in(sample_1, door_1)" in believed(api)
    assert "in(sample_1, bay_7)" not in believed(api)


def test_after_a_failure_the_same_goal_can_be_planned_again(
    start: Callable[[], str], follow: Follow, team: FakeTeam
) -> None:
    team.faults.fails_at = dict.fromkeys(("yard_1", "yard_2"), "DOCK")
    assert follow(start(), *ENDED)["state"] == "failed"
    team.faults.fails_at = {}
    assert follow(start(), *ENDED)["state"] == "completed"


def test_a_refused_script_fails_the_mission_with_the_robots_reason(
    start: Callable[[], str], follow: Follow, team: FakeTeam
) -> None:
    team.faults.refuses = {"yard_1", "yard_2"}
    ended = follow(start(), *ENDED)
    assert ended["state"] == "failed"
    assert "is not willing" in ended["reason"]


def test_a_cancelled_mission_stops_every_robot(
    start: Callable[[], str], follow: Follow, team: FakeTeam, api: TestClient
) -> None:
    team.faults.stuck.add("store_2")
    mission = start()
    follow(mission, "running")
    assert api.post(f"{mission}:cancel", json={"comment": "changed my mind"}).status_code == 202
    assert follow(mission, *ENDED)["state"] == "cancelled"
    robots = {script["robot"]: script["state"] for script in api.get(mission).json()["progress"]}
    assert robots["store_2"] == "cancelled"
    again = api.post(f"{mission}:cancel", json={})
    assert again.status_code in (202, 409)
    assert api.post(f"{mission}:pause", json={}).status_code == 409


def test_a_cancel_reaches_a_robot_that_never_got_its_script(
    start: Callable[[], str], follow: Follow, team: FakeTeam, api: TestClient
) -> None:
    team.faults.silent.add("store_2")
    mission = start()
    assert not follow(mission, "running")["cancel_requested"]
    assert api.post(f"{mission}:cancel", json={}).json()["cancel_requested"]
    unknown = follow(mission, "unknown", *ENDED)
    assert (unknown["state"], unknown["cancel_requested"]) == ("unknown", True)
    assert "no answer from store_2" in unknown["reason"]
    team.faults.silent.clear()
    assert follow(mission, "cancelled", "failed")["state"] == "cancelled"
    (script,) = [one for one in api.get(mission).json()["progress"] if one["robot"] == "store_2"]
    assert (script["state"], script["delivery"]) == ("cancelled", "withdrawn")
    assert team.robots["store_2"].executed == []


def test_a_paused_mission_waits_and_goes_on_when_resumed(
    start: Callable[[], str], follow: Follow, team: FakeTeam, api: TestClient
) -> None:
    team.faults.stuck.add("store_2")
    mission = start()
    follow(mission, "running")
    assert api.post(f"{mission}:pause", json={}).json()["state"] == "paused"
    assert api.post(f"{mission}:resume", json={}).status_code == 202
    follow(mission, "running")
    team.faults.stuck.clear()
    assert follow(mission, *ENDED)["state"] == "completed"


def test_scripts_that_all_finish_without_the_goal_being_true_then_are_not_a_success(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_1")
    goal = api.post(
        "/v1/goals", json={"text": "move sample_1 to bay_7 and sample_2 to bay_3", "recovery": "never"}
    ).json()
    plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
    mission = f"/v1/missions/{api.post(f'/v1/plans/{plan_id}:approve').json()['mission_id']}"
    until(lambda: "in(sample_1, bay_7)" in believed(api))
    moved = {"facts": [{"predicate": "in", "args": ["sample_1", "bay_12"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=moved).status_code == 200
    team.faults.stuck.clear()
    ended = follow(mission, *ENDED)
    assert ended["state"] == "partially_completed"
    assert "in(sample_1, bay_7)" in ended["reason"]


def test_a_script_that_has_finished_has_finished_its_packets_though_a_report_is_missing(
    start: Callable[[], str], follow: Follow, team: FakeTeam, api: TestClient
) -> None:
    team.faults.stuck.add("store_2")
    mission = start()
    follow(mission, "running")
    packets = next(s for s in api.get(mission).json()["progress"] if s["robot"] == "store_2")["packets"]
    team.unbelieved = packets[-1]["id"]
    team.faults.stuck.clear()
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed"
    assert "in(sample_1, bay_7)" in believed(api)


def test_a_late_report_of_what_others_have_gone_on_with_changes_nothing_of_theirs(
    start: Callable[[], str], follow: Follow, team: FakeTeam, api: TestClient
) -> None:
    team.faults.late_s["yard_2", "RELEASE2"] = team.faults.late_s["yard_1", "RELEASE2"] = 1000.0
    follow(start(), "completed")
    places = {fact for fact in believed(api) if fact.startswith("in(sample_1, ")}
    assert places == {"in(sample_1, bay_7)"}
    assert {"vacant(interchange_1)", "vacant(interchange_2)"} <= believed(api)


def test_what_a_packet_raises_on_its_way_is_reported_to_the_operator(
    start: Callable[[], str], follow: Follow, service: Service
) -> None:
    follow(start(), *ENDED)
    assert all(event["events"] == ["goal"] for event in events(service, "packet.finished"))
    assert all(event["events"] == [] for event in events(service, "packet.running"))
    assert events(service, "packet.finished")


def test_a_script_that_is_lost_on_the_way_is_sent_again_under_the_same_id(
    start: Callable[[], str], follow: Follow, team: FakeTeam
) -> None:
    team.faults.lost = 3
    assert follow(start(), *ENDED)["state"] == "completed"
    requests = [message_id for message_id in team.arrived if message_id.endswith(":request")]
    assert len(requests) >= 5
    assert len(set(requests)) == 2
    assert all(len(set(robot.executed)) == len(robot.executed) for robot in team.robots.values())


def test_every_report_is_receipted(start: Callable[[], str], follow: Follow, team: FakeTeam) -> None:
    follow(start(), "completed")
    until(lambda: len(set(team.receipts)) >= 2 * 8 + 2)
