"""An operator has what a mission has not done planned again, with something pinned of it."""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.waiting import ENDED, read_until, until

Thing = dict[str, Any]
FOR_EVER_S = 1_000_000.0
OTHER = {"yard_1": "yard_2", "yard_2": "yard_1"}


def on_the_way(start: Start, api: TestClient, team: FakeTeam, policy: str) -> tuple[str, str, str]:
    """A mission whose yard robot carries its sample; its path, that robot and the action that grips the sample."""
    team.faults.takes_s = {"TRANSPORT": FOR_EVER_S}
    mission, yard = start(policy)
    until(lambda: yard in team.robots and team.robots[yard].left_s > FOR_EVER_S / 2)
    team.faults.takes_s = {}
    (dock,) = [
        packet["id"]
        for script in api.get(mission).json()["progress"]
        for packet in script["packets"]
        if script["robot"] == yard and packet["tag"] == "DOCK"
    ]
    return mission, yard, dock


def attempts(mission: Thing) -> list[tuple[str | None, str | None, str]]:
    return [(one["failure"], one["measure"], one["outcome"]) for one in mission["recovery"]["attempts"]]


def deciding(mission: Thing) -> bool:
    return bool(mission["recovery"]["step"] == "deciding" or mission["state"] in ENDED)


@pytest.mark.parametrize("policy", ["auto", "never"])
def test_what_is_left_is_planned_again_without_a_failure_and_without_a_try(
    policy: str, start: Start, api: TestClient, follow: Follow, team: FakeTeam, service: Service
) -> None:
    mission, yard, _ = on_the_way(start, api, team, policy)
    asked = api.post(f"{mission}:replan", json={"comment": "yard_2 is back"})
    assert asked.status_code == 202, asked.text
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["reason"], ended["failure"]) == ("completed", "", None)
    assert attempts(ended) == [(None, "repair", "approved")]  # from where the robots have stopped
    assert ended["recovery"]["tries_left"] == 4
    assert ended["recovery"]["attempts"][0]["reason"] == (
        "an operator has asked for another plan: yard_2 is back"
    )
    assert [deed[0] for deed in team.robots[yard].deeds].count("DOCK") == 1, "what was done is done again"
    told = [row for row in service.events.since(0) if row.type == "mission.replan_requested"]
    assert [(row.subject, row.data["comment"], row.data["pinned"]) for row in told] == [
        (ended["id"], "yard_2 is back", "")
    ]


def test_what_is_pinned_is_kept_and_stays_pinned(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.takes_s = {"NAVIGATE": FOR_EVER_S}
    mission, yard = start("auto")
    until(lambda: yard in team.robots and team.robots[yard].left_s > FOR_EVER_S / 2)
    team.faults.takes_s = {}
    plan = api.get(f"/v1/plans/{api.get(mission).json()['plan_id']}").json()
    dock = next(one["id"] for one in plan["actions"] if one["tag"] == "DOCK" and yard in one["agents"])
    edits = [{"action": dock, "robot": OTHER[yard]}]
    assert api.post(f"{mission}:replan", json={"edits": edits}).status_code == 202
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert "DOCK" not in [deed[0] for deed in team.robots[yard].deeds]
    assert "DOCK" in [deed[0] for deed in team.robots[OTHER[yard]].deeds]
    now = api.get(f"/v1/plans/{ended['plan_id']}").json()
    assert [pin["words"] for pin in now["edits"]] == [[f"{OTHER[yard]} for in(sample_1, bay_7)"]]


def test_a_plan_that_was_asked_for_waits_for_a_decision_and_once_rejected_the_one_before_goes_on(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, yard, dock = on_the_way(start, api, team, "ask")
    edits = [{"action": dock, "not_before_s": 200}]
    assert api.post(f"{mission}:replan", json={"edits": edits}).status_code == 202
    asked = read_until(api, mission, deciding)
    plan_id = asked["recovery"]["attempts"][-1]["plan_id"]
    assert f"plan {plan_id} waits for a decision" in asked["reason"]
    assert api.post(f"/v1/plans/{plan_id}:reject", json={"comment": "too late"}).status_code == 202
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert [(failure, outcome) for failure, _, outcome in attempts(ended)] == [
        (None, "rejected"),
        (None, "approved"),
    ]
    assert ended["recovery"]["attempts"][1]["reason"] == "the other plan was rejected: too late"
    assert api.get(f"/v1/plans/{ended['plan_id']}").json()["edits"] == []
    assert [deed[0] for deed in team.robots[yard].deeds].count("RELEASE2") == 1


def test_a_failure_meanwhile_is_counted_and_what_is_pinned_is_kept(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, _, dock = on_the_way(start, api, team, "auto")
    team.faults.fails_at, team.faults.failures_left = {"store_2": "DOCK"}, 1
    edits = [{"action": dock, "avoid": "interchange_1"}]
    assert api.post(f"{mission}:replan", json={"edits": edits}).status_code == 202
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert [failure for failure, _, _ in attempts(ended)] == [None, "robot"]
    assert ended["recovery"]["tries_left"] == 3
    assert [pin["avoided"] for pin in api.get(f"/v1/plans/{ended['plan_id']}").json()["edits"]] == [
        ["interchange_1"]
    ]


def test_what_cannot_be_planned_again_is_refused_with_the_reason(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, yard, dock = on_the_way(start, api, team, "ask")

    def refused(status: int, code: str, **body: Any) -> str:
        answer = api.post(f"{mission}:replan", json=body)
        assert (answer.status_code, answer.json()["type"].split(":")[-1]) == (status, code), answer.text
        return str(answer.json()["detail"])

    assert "the plan has no action a99" in refused(
        422, "cannot-edit", edits=[{"action": "a99", "robot": yard}]
    )
    assert f"{yard} has sample_1 already" in refused(
        422, "cannot-edit", edits=[{"action": dock, "robot": OTHER[yard]}]
    )
    assert "no interchange" in refused(422, "no-interchange", edits=[{"action": dock, "via": "bay_1"}])
    refused(422, "malformed-request", edits=[{"action": dock}])
    now = follow(mission, "running")
    assert (now["recovery"]["attempts"], now["revision"]) == ([], 1), "what is refused changes nothing"
    assert api.post(f"{mission}:pause").status_code == 202
    assert "resume it" in refused(409, "mission-paused")
    assert api.post(f"{mission}:resume").status_code == 202
    team.faults.silent |= {
        "yard_1",
        "yard_2",
        "store_1",
        "store_2",
    }  # so that it does not end before it is asked again
    assert api.post(f"{mission}:replan").status_code == 202
    assert "already" in refused(409, "being-replanned")
    assert api.post(f"{mission}:cancel").status_code == 202
    refused(409, "being-cancelled")
    team.faults.silent.clear()
    follow(mission, *ENDED)
    assert "cannot be planned again" in refused(409, "mission-ended")
    assert api.post("/v1/missions/mission-0:replan").status_code == 404


def test_without_another_plan_the_mission_waits_for_the_robot_that_it_needs(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    """The only robot of the aisle is out of service."""
    mission, _, _ = on_the_way(start, api, team, "auto")
    leave = {"robots": ["store_2"], "reason": "its gripper is cleaned"}
    assert api.post("/v1/robots:take_out_of_service", json=leave).status_code == 200
    assert api.post(f"{mission}:replan").status_code == 202
    waiting = read_until(
        api, mission, lambda now: now["recovery"]["step"] == "waiting" or now["state"] in ENDED
    )
    assert (waiting["state"], waiting["recovery"]["step"]) == ("recovering", "waiting"), waiting["reason"]
    assert api.post("/v1/robots:bring_back", json={"robots": ["store_2"]}).status_code == 200
    assert follow(mission, *ENDED)["state"] == "completed"
