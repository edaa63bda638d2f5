"""An operator looks at what would come of having a mission planned again, while its robots go on."""

import threading
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.missions import replanning
from app.missions.replanning import MAX_CONCURRENT
from app.planning.job import PlanningTask
from app.planning.pool.work import Solutions, Work
from planner import KnowledgeBase
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.waiting import ENDED, until

Thing = dict[str, Any]
FOR_EVER_S = 1_000_000.0
TEAM = ("yard_1", "yard_2", "store_1", "store_2")


def under_way(start: Start, team: FakeTeam, tag: str = "TRANSPORT") -> tuple[str, str]:
    """A mission whose yard robot is busy with this packet, and that robot."""
    team.faults.takes_s = {tag: FOR_EVER_S}
    mission, yard = start("ask")
    until(lambda: yard in team.robots and team.robots[yard].left_s > FOR_EVER_S / 2)
    return mission, yard


def preview(api: TestClient, mission: str, **asked: Any) -> Thing:
    answer = api.post(f"{mission}:preview", json=asked)
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def test_a_preview_tells_when_each_goal_would_be_true_and_changes_nothing(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam, service: Service
) -> None:
    mission, yard = under_way(start, team)
    before = follow(mission, "running")
    shown = preview(api, mission)
    assert shown["reason"] == shown["unkept"] == ""
    assert yard in shown["robots"]
    (achieved,) = shown["achieved"]
    assert achieved["goal"]["args"] == ["sample_1", "bay_7"]
    assert 0 < achieved["in_s"] <= shown["ends_in_s"]
    assert shown["expected_in_s"] is not None
    assert any("actions kept" in line for line in shown["changes"])
    after = follow(mission, "running")
    assert (after["recovery"], after["plan_id"]) == (before["recovery"], before["plan_id"])
    told = [row.type for row in service.events.since(0)]
    assert told.count("plan.proposed") == 1
    assert "mission.replan_requested" not in told
    assert team.robots[yard].left_s > FOR_EVER_S / 2, "the robot was stopped"


def test_what_is_previewed_is_what_a_mission_that_is_planned_again_does(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, yard = under_way(start, team, "NAVIGATE")
    team.faults.takes_s = {}
    other = {"yard_1": "yard_2", "yard_2": "yard_1"}[yard]
    plan = api.get(f"/v1/plans/{api.get(mission).json()['plan_id']}").json()
    dock = next(one["id"] for one in plan["actions"] if one["tag"] == "DOCK" and yard in one["agents"])
    edits = [{"action": dock, "robot": other}]
    shown = preview(api, mission, edits=edits)
    assert (yard in shown["robots"], other in shown["robots"]) == (False, True)
    assert api.post(f"{mission}:replan", json={"edits": edits}).status_code == 202
    until(lambda: api.get(mission).json()["recovery"]["step"] == "deciding")
    made = api.get(f"/v1/plans/{api.get(mission).json()['recovery']['attempts'][-1]['plan_id']}").json()
    assert made["robots"] == shown["robots"]


def test_a_preview_of_goals_that_wait_tells_when_each_would_be_true_or_why_there_is_no_plan(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, _ = under_way(start, team)
    busy = {script["robot"] for script in api.get(mission).json()["progress"]}
    idle = [robot for robot in TEAM if robot not in busy]
    api.post("/v1/robots:take_out_of_service", json={"robots": idle, "reason": "snow"}).raise_for_status()
    goals = []
    for text in ("move sample_4 to bay_8", "move sample_2 to bay_8"):
        goals.append(api.post("/v1/goals", json={"text": text}).json()["id"])
        follow(f"/v1/goals/{goals[-1]}", "waiting")
    shown = preview(api, mission, goals=goals[:1])
    assert {one["goal"]["args"][0] for one in shown["achieved"]} == {"sample_1", "sample_4"}
    none = preview(api, mission, goals=goals[1:])
    assert (none["ends_in_s"], none["achieved"]) == (None, [])
    assert none["reason"].startswith("waits for store_1, which administrator took out of service")
    assert api.get(f"/v1/goals/{goals[0]}").json()["joint_goal"] is None


def test_what_cannot_be_planned_again_cannot_be_previewed(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission, _ = under_way(start, team)

    def refused(status: int, **asked: Any) -> str:
        answer = api.post(f"{mission}:preview", json=asked)
        assert answer.status_code == status, answer.text
        return str(answer.json()["detail"])

    assert "the plan has no action a99" in refused(422, edits=[{"action": "a99", "robot": "yard_1"}])
    assert "no goal" in refused(404, goals=["goal-0"])
    assert api.post("/v1/missions/mission-0:preview").status_code == 404
    api.post(f"{mission}:pause").raise_for_status()
    assert "resume it" in refused(409)
    api.post(f"{mission}:resume").raise_for_status()
    team.faults.takes_s = {}
    api.post(f"{mission}:cancel").raise_for_status()
    follow(mission, *ENDED)
    assert "it cannot be planned again any longer" in refused(409)


def test_only_so_many_previews_are_made_at_a_time(
    start: Start, api: TestClient, team: FakeTeam, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission, _ = under_way(start, team)
    all_in, leave = threading.Barrier(MAX_CONCURRENT + 1), threading.Event()
    work_of = replanning.work_of

    def held(task: PlanningTask, knowledge_base: KnowledgeBase) -> Work[Solutions]:
        all_in.wait(60)
        assert leave.wait(60)
        return work_of(task, knowledge_base)

    monkeypatch.setattr(replanning, "work_of", held)
    asking = [threading.Thread(target=preview, args=(api, mission)) for _ in range(MAX_CONCURRENT)]
    for one in asking:
        one.start()
    all_in.wait(60)
    refused = api.post(f"{mission}:preview")
    assert (refused.status_code, refused.headers["retry-after"]) == (429, "10")
    assert refused.json()["detail"] == "4 previews are being made; ask again later"
    leave.set()
    for one in asking:
        one.join()
    monkeypatch.undo()
    assert preview(api, mission)["reason"] == ""
