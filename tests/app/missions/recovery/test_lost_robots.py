"""Robots that fall silent, are declared lost, and come back: nobody waits for them, nothing they did is forgotten."""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from robots.wire import PacketReport, PacketState, ScriptReport, ScriptState
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.waiting import ENDED, read_until, until

Thing = dict[str, Any]
FACTS = "/v1/worlds/sample_store/facts"
UNKNOWN = "/v1/worlds/sample_store/unknown"


def held(api: TestClient) -> set[str]:
    items = api.get(FACTS).json()["items"]
    return {f"{fact['predicate']}({', '.join(fact['args'])})" for fact in items}


@pytest.fixture
def silent(start: Start, follow: Follow, team: FakeTeam) -> tuple[str, str]:
    """A mission whose yard robot has fallen silent before it did anything; its path and the robot."""
    team.faults.stuck |= {"yard_1", "yard_2"}
    mission, yard = start("auto")
    follow(mission, "dispatching", "running")
    until_acknowledged(team, yard)
    team.faults.silent.add(yard)
    assert follow(mission, "unknown")["failure"] == "unreachable"
    team.faults.stuck.clear()
    return mission, yard


def until_acknowledged(team: FakeTeam, robot: str) -> None:
    until(lambda: robot in team.robots and team.robots[robot].script is not None)


def test_how_a_silent_robot_stands_is_shown_as_not_known(api: TestClient, silent: tuple[str, str]) -> None:
    mission, yard = silent
    (item,) = api.get(UNKNOWN).json()["items"]
    assert (item["name"], item["kind"]) == (yard, "robot")
    assert mission.rpartition("/")[2] in item["reason"]
    assert item["last_believed"]["args"][0] == yard


def test_without_a_lost_robot_another_takes_over(
    api: TestClient, follow: Follow, team: FakeTeam, silent: tuple[str, str]
) -> None:
    mission, yard = silent
    answer = api.post(f"/v1/robots/{yard}:declare_lost", json={"comment": "fell down the crater"})
    assert answer.status_code == 202, answer.text
    assert answer.json()["lost"]["declared_by"] == "administrator"
    again = api.post(f"/v1/robots/{yard}:declare_lost", json={"comment": "twice"})
    assert again.json()["lost"]["comment"] == "fell down the crater"
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    (attempt,) = ended["recovery"]["attempts"]
    assert (attempt["measure"], attempt["failure"], attempt["without"]) == ("replan", "unreachable", [yard])
    assert [script["lost"] for script in ended["earlier"] if script["robot"] == yard] == [True]
    assert team.robots[yard].executed == []
    assert [item["name"] for item in api.get(UNKNOWN).json()["items"]] == [yard]


def test_a_lost_robot_is_stopped_when_it_is_heard_again_and_counts_once_it_has(
    api: TestClient, follow: Follow, team: FakeTeam, silent: tuple[str, str], service: Service
) -> None:
    mission, yard = silent
    team.faults.stuck.add(yard)  # it stands where it is until it is told something
    api.post(f"/v1/robots/{yard}:declare_lost")
    assert follow(mission, *ENDED)["state"] == "completed"
    owes = api.post(f"/v1/robots/{yard}:declare_found")
    assert (owes.status_code, owes.json()["type"]) == (409, "urn:macta:problem:script-unresolved")
    team.faults.silent.clear()
    found = read_until(api, f"/v1/robots/{yard}", lambda robot: robot["lost"] is None)
    assert found["connection"] == "online"
    assert team.robots[yard].state is ScriptState.CANCELLED
    assert team.robots[yard].executed == []
    assert any(row.type == "robot.found" for row in service.events.since(0))
    assert api.get(UNKNOWN).json()["items"] == []
    assert api.get(mission).json()["state"] == "completed"


def test_a_robot_in_contact_that_was_declared_lost_comes_back_only_on_an_operators_word(
    api: TestClient, team: FakeTeam, follow: Follow
) -> None:
    team.tell("yard_1", battery=1.0)
    read_until(api, "/v1/robots/yard_1", lambda robot: robot["connection"] == "online")
    assert api.post("/v1/robots/yard_1:declare_lost").json()["lost"]["silent"] is False
    team.tell("yard_1", battery=1.0)
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
    plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
    assert "yard_1" not in api.get(f"/v1/plans/{plan_id}").json()["robots"]
    assert api.get("/v1/robots/yard_1").json()["lost"] is not None
    assert api.post("/v1/robots/yard_1:declare_found").json()["lost"] is None
    assert api.post("/v1/robots/yard_1:declare_found").status_code == 409
    assert api.post("/v1/robots/nobody:declare_lost").status_code == 404


def test_a_plan_with_a_robot_that_was_lost_meanwhile_is_not_approved(api: TestClient, follow: Follow) -> None:
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
    plan_id = follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"]
    yard = next(r for r in api.get(f"/v1/plans/{plan_id}").json()["robots"] if r.startswith("yard"))
    api.post(f"/v1/robots/{yard}:declare_lost")
    stale = api.post(f"/v1/plans/{plan_id}:approve")
    assert stale.status_code == 409
    assert f"{yard} was declared lost" in stale.json()["detail"]


def test_a_lost_robot_that_had_delivered_after_all_has_the_mission_end_as_it_stands(
    api: TestClient, start: Start, follow: Follow, team: FakeTeam, service: Service
) -> None:
    """The store robot did its work unheard; the mission looked for another way, and there is none."""
    team.faults.stuck.add("store_2")
    mission, _ = start("ask")
    read_until(api, mission, lambda now: any(s["state"] == "finished" for s in now["progress"]))
    script = team.robots["store_2"].script
    assert script is not None
    team.faults.silent.add("store_2")
    follow(mission, "unknown")
    api.post("/v1/robots/store_2:declare_lost")
    read_until(api, mission, lambda now: now["recovery"]["step"] in ("stuck", "deciding"))
    at_s = team.clock.now_s()
    for packet in script.packets:
        at_s += packet.expected_duration_s
        done = PacketReport(script_id=script.id, packet_id=packet.id, state=PacketState.FINISHED, at_s=at_s)
        team.report("store_2", done)
    team.report("store_2", ScriptReport(script_id=script.id, state=ScriptState.FINISHED, at_s=at_s))
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert "in(sample_1, bay_7)" in held(api)
    assert any(row.type == "world.contradicted" for row in service.events.since(0))


def test_what_a_lost_robot_held_is_not_known_either(
    api: TestClient, start: Start, follow: Follow, team: FakeTeam
) -> None:
    team.faults.takes_s = {"TRANSPORT": 1_000_000.0}
    _, yard = start("never")
    read_until(api, FACTS, lambda facts: ["sample_1", yard] in [fact["args"] for fact in facts["items"]])
    team.faults.silent.add(yard)
    api.post(f"/v1/robots/{yard}:declare_lost")
    unknown = {item["name"]: item for item in api.get(UNKNOWN).json()["items"]}
    assert unknown["sample_1"]["reason"] == f"it was in {yard}, which administrator declared lost"
    assert unknown["sample_1"]["last_believed"]["args"] == ["sample_1", yard]


def test_a_late_report_does_not_overwrite_what_is_known_since(
    api: TestClient, start: Start, follow: Follow, team: FakeTeam, service: Service
) -> None:
    team.faults.stuck |= {"yard_1", "yard_2"}
    mission, yard = start("never")
    follow(mission, "dispatching", "running")
    until_acknowledged(team, yard)
    script = team.robots[yard].script
    assert script is not None
    at_s = team.clock.now_s()
    until(lambda: team.clock.now_s() > at_s)
    said = {"facts": [{"predicate": "in", "args": ["sample_1", "door_2"]}], "comment": "I see it"}
    assert api.put(FACTS, json=said).status_code == 200
    docked = next(packet for packet in script.packets if packet.tag == "DOCK")
    late = PacketReport(script_id=script.id, packet_id=docked.id, state=PacketState.FINISHED, at_s=at_s)
    team.report(yard, late)
    until(lambda: any(row.type == "world.late_report" for row in service.events.since(0)))
    assert "in(sample_1, door_2)" in held(api)
    assert f"in(sample_1, {yard})" not in held(api)
