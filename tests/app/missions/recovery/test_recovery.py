"""Missions that fail and are recovered: the same again, a repair, a plan without a robot, the operator."""

import time
from typing import Any

from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.waiting import ENDED, read_until

Thing = dict[str, Any]


def deciding(mission: Thing) -> bool:
    return bool(mission["recovery"]["step"] == "deciding")


def attempts(mission: Thing) -> list[tuple[str | None, str]]:
    return [(one["measure"], one["outcome"]) for one in mission["recovery"]["attempts"]]


def packets_of(mission: Thing, robot: str) -> list[Thing]:
    return [
        packet for script in mission["progress"] if script["robot"] == robot for packet in script["packets"]
    ]


def open_plan(api: TestClient, mission: Thing) -> Thing:
    plan: Thing = api.get(f"/v1/plans/{mission['recovery']['attempts'][-1]['plan_id']}").json()
    return plan


def test_a_robot_that_fails_once_tries_the_same_again_without_a_decision(
    start: Start, follow: Follow, team: FakeTeam, service: Service
) -> None:
    mission, yard = start("ask", fails="DOCK", times=1)
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert attempts(ended) == [("retry", "approved")]
    assert ended["revision"] == 2
    (attempt,) = ended["recovery"]["attempts"]
    assert attempt["failure"] == "robot"
    assert "the gripper does not close" in attempt["reason"]
    deeds = team.robots[yard].deeds
    assert len(deeds) == len(set(deeds)), "something that was done has been done again"
    told = [row.type for row in service.events.since(0) if row.subject == ended["id"]]
    assert told.count("mission.recovery_begun") == told.count("mission.revised") == 1
    told = [type_ for type_ in told if type_.startswith("mission.rec") or type_ == "mission.revised"]
    assert list(dict.fromkeys(told)) == [  # it may be unknown for a moment, and then be recovering again
        "mission.recovering",
        "mission.recovery_begun",
        "mission.revised",
    ]


def test_a_robot_that_goes_on_failing_is_left_out_and_another_takes_over(
    start: Start, follow: Follow, team: FakeTeam
) -> None:
    mission, yard = start("auto", fails="DOCK")
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert attempts(ended) == [("retry", "approved"), ("replan", "approved")]
    assert ended["recovery"]["attempts"][-1]["without"] == [f"DOCK by {yard}"]
    assert "DOCK" not in {packet["tag"] for packet in packets_of(ended, yard)}
    assert [script["state"] for script in ended["earlier"] if script["robot"] == yard] == ["failed", "failed"]
    docks = [deed for robot in team.robots.values() for deed in robot.deeds if deed[0] == "DOCK"]
    assert len(docks) == 2  # at the door and at the interchange


def test_what_is_done_is_kept_when_a_later_robot_fails(start: Start, follow: Follow, team: FakeTeam) -> None:
    team.faults.fails_at, team.faults.failures_left = {"store_2": "DOCK"}, 1
    mission, yard = start("ask")
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert [script["robot"] for script in ended["progress"]] == ["store_2"]
    assert [deed[0] for deed in team.robots[yard].deeds].count("RELEASE2") == 1


def test_a_repair_waits_for_the_decision_and_shows_its_difference(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, yard = start("ask", fails="DOCK")
    asked = read_until(api, mission, deciding)
    assert asked["state"] == "recovering"
    plan = open_plan(api, asked)
    assert plan["state"] == "proposed"
    assert plan["repairs"]["plan_id"] == asked["plan_id"]
    assert plan["repairs"]["difference"]["words"]
    assert (yard, "DOCK") not in {(action["agents"][0], action["tag"]) for action in plan["actions"]}
    assert plan["id"] in asked["reason"]
    assert api.get(f"/v1/goals/{asked['goal_id']}").json()["plan_id"] == plan["id"]
    before = {name: len(robot.deeds) for name, robot in team.robots.items()}
    time.sleep(0.5)
    assert {name: len(robot.deeds) for name, robot in team.robots.items()} == before
    decided = api.post(f"/v1/plans/{plan['id']}:approve")
    assert decided.status_code == 202
    assert decided.json()["mission_id"] == asked["id"]
    assert follow(mission, *ENDED)["state"] == "completed"
    again = api.post(f"/v1/plans/{plan['id']}:approve")
    assert (again.status_code, again.json()["mission_id"]) == (202, asked["id"])


def test_a_repair_that_is_rejected_ends_the_mission_truthfully(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, _ = start("ask", fails="DOCK")
    plan = open_plan(api, read_until(api, mission, deciding))
    assert api.post(f"/v1/plans/{plan['id']}:reject", json={"comment": "leave it"}).status_code == 202
    ended = follow(mission, *ENDED)
    assert ended["state"] == "failed"
    assert "the gripper does not close" in ended["reason"]
    assert "the repair was rejected: leave it" in ended["reason"]
    assert attempts(ended)[-1] == ("replan", "rejected")
    goal = api.get(f"/v1/goals/{ended['goal_id']}").json()
    assert (goal["state"], goal["outcome"]) == ("finished", "failed")
    assert {script["state"] for script in ended["progress"]} <= {"failed", "cancelled"}


def test_a_repair_that_the_world_overtakes_is_made_again(
    start: Start, api: TestClient, follow: Follow
) -> None:
    mission, _ = start("ask", fails="DOCK")
    plan = open_plan(api, read_until(api, mission, deciding))
    move(api, "sample_1", "door_2")
    stale = api.post(f"/v1/plans/{plan['id']}:approve")
    assert (stale.status_code, stale.json()["type"]) == (409, "urn:macta:problem:plan-stale")
    fresh = read_until(api, mission, lambda now: deciding(now) and open_plan(api, now)["id"] != plan["id"])
    assert api.post(f"/v1/plans/{open_plan(api, fresh)['id']}:approve").status_code == 202
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert ("replan", "overtaken") in attempts(ended)


def move(api: TestClient, sample: str, place: str) -> None:
    body = {"facts": [{"predicate": "in", "args": [sample, place]}]}
    answer = api.put("/v1/worlds/sample_store/facts", json=body)
    assert answer.status_code == 200, answer.text


def test_without_a_plan_an_automatic_recovery_ends_with_both_reasons(
    start: Start, follow: Follow, team: FakeTeam
) -> None:
    team.faults.refuses = {"yard_1", "yard_2"}
    mission, yard = start("auto")
    ended = follow(mission, *ENDED)
    assert ended["state"] == "failed"
    assert "is not willing" in ended["reason"]
    assert f"{yard} is not willing" in ended["recovery"]["attempts"][0]["reason"]
    assert "no plan was found without yard_1, yard_2" in ended["reason"]
    assert ended["failure"] == "robot"


def test_without_a_plan_an_operator_is_asked_and_can_have_it_tried_again(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck |= {"yard_1", "yard_2"}
    mission, _ = start("ask")
    read_until(api, mission, lambda now: all(s["delivery"] == "acknowledged" for s in now["progress"]))
    lame = [{"predicate": "can", "args": [f"yard_{n}", "DOCK"], "value": False} for n in (1, 2)]
    assert api.put("/v1/worlds/sample_store/facts", json={"facts": lame}).status_code == 200
    stuck = read_until(api, mission, lambda now: now["recovery"]["step"] == "stuck")
    assert stuck["state"] == "recovering"
    assert "can(yard_" in stuck["reason"], stuck["reason"]
    assert stuck["failure"] == "world_changed"
    lame[1]["value"] = lame[0]["value"] = True
    assert api.put("/v1/worlds/sample_store/facts", json={"facts": lame}).status_code == 200
    team.faults.stuck.clear()
    assert api.post(f"{mission}:resume").status_code == 202
    asked = read_until(api, mission, lambda now: deciding(now) or now["state"] in ENDED)
    if asked["state"] not in ENDED:
        assert api.post(f"/v1/plans/{open_plan(api, asked)['id']}:approve").status_code == 202
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]


def test_a_sample_that_an_operator_moves_is_fetched_from_where_it_lies_now(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck |= {"yard_1", "yard_2", "store_1", "store_2"}
    mission, _ = start("auto")
    read_until(api, mission, lambda now: all(s["delivery"] == "acknowledged" for s in now["progress"]))
    move(api, "sample_1", "door_2")
    revised = read_until(api, mission, lambda now: now["revision"] == 2)
    team.faults.stuck.clear()
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert revised["recovery"]["attempts"][0]["failure"] == "world_changed"
    assert "in(sample_1, door_1) is no longer true" in revised["recovery"]["attempts"][0]["reason"]
    assert any("door_2" in deed for robot in team.robots.values() for deed in robot.deeds)


def test_the_policy_can_be_set_while_the_mission_runs(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck |= {"yard_1", "yard_2"}
    mission, _ = start("ask", fails="DOCK")
    answer = api.put(f"{mission}/recovery", json={"policy": "never"})
    assert (answer.status_code, answer.json()["recovery"]["policy"]) == (200, "never")
    team.faults.stuck.clear()
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["recovery"]["attempts"]) == ("failed", [])
    assert api.put(f"{mission}/recovery", json={"policy": "auto"}).status_code == 409
