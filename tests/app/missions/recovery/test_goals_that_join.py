"""A mission under way is planned again with goals that wait, which it then carries out, too."""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.domain.lifecycles import goal as goal_lifecycle
from app.store import GoalRow
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.databases import ON_BOTH
from tests.waiting import ENDED, read_until, until

Thing = dict[str, Any]
SUBMITTED = 202
FOR_EVER_S = 1_000_000.0
TEAM = ("yard_1", "yard_2", "store_1", "store_2")


@pytest.fixture
def mission(start: Start, api: TestClient, team: FakeTeam) -> str:
    """The path of a mission whose robots are on their way; the other robots are out of service."""
    return under_way(start, api, team, "auto")


def under_way(start: Start, api: TestClient, team: FakeTeam, policy: str, **wishes: Any) -> str:
    team.faults.takes_s = {"TRANSPORT": FOR_EVER_S}
    mission, yard = start(policy, **wishes)
    until(lambda: yard in team.robots and team.robots[yard].left_s > FOR_EVER_S / 2)
    team.faults.takes_s = {}
    busy = {script["robot"] for script in api.get(mission).json()["progress"]}
    idle = [robot for robot in TEAM if robot not in busy]
    api.post("/v1/robots:take_out_of_service", json={"robots": idle, "reason": "snow"}).raise_for_status()
    return mission


def waiting(api: TestClient, follow: Follow, text: str = "move sample_4 to bay_8", **wishes: Any) -> str:
    """The id of a goal that waits for the mission's robots."""
    goal = api.post("/v1/goals", json={"text": text, **wishes}).raise_for_status().json()["id"]
    follow(f"/v1/goals/{goal}", "waiting")
    return str(goal)


def ask(api: TestClient, mission: str, *goals: str, status: int = SUBMITTED) -> Thing:
    answer = api.post(f"{mission}:replan", json={"goals": goals})
    assert answer.status_code == status, answer.text
    return dict(answer.json())


def goal_of(api: TestClient, goal_id: str) -> Thing:
    return dict(api.get(f"/v1/goals/{goal_id}").raise_for_status().json())


@ON_BOTH
def test_a_goal_that_waits_is_carried_out_by_the_mission_that_it_joins(
    mission: str, api: TestClient, follow: Follow, service: Service
) -> None:
    goal = waiting(api, follow)
    own = ask(api, mission, goal)["goal_id"]
    joined = goal_of(api, goal)
    assert (joined["state"], joined["joint_goal"]) == ("waiting", own)
    assert joined["reason"] == f"waits for {mission.rsplit('/', maxsplit=1)[-1]}, which is planned with it"
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["reason"], ended["joined_goals"]) == ("completed", "", [goal]), ended[
        "recovery"
    ]
    assert [(one["goals"], one["outcome"]) for one in ended["recovery"]["attempts"]] == [([goal], "approved")]
    carried_out = follow(f"/v1/goals/{goal}", "finished")
    assert (carried_out["outcome"], carried_out["mission_id"]) == ("completed", ended["id"])
    facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
    lie = {tuple(fact["args"]) for fact in facts if fact["predicate"] == "in"}
    assert {("sample_1", "bay_7"), ("sample_4", "bay_8")} <= lie
    (told,) = [row for row in service.events.since(0) if row.type == "mission.replan_requested"]
    assert told.data["goals"] == [goal]


def test_a_goal_that_is_just_tried_again_joins_and_what_comes_of_its_own_planning_is_dropped(
    mission: str, api: TestClient, follow: Follow, service: Service
) -> None:
    """A goal that waits is tried whenever a robot has ended something."""
    goal = waiting(api, follow)
    until(lambda: goal_of(api, goal)["state"] == "waiting")
    with service.database.write() as session:
        row = session.get_one(GoalRow, goal, with_for_update=True)
        goal_lifecycle.begin_planning(row)
        row.planned_by = "its own planning"
    own = ask(api, mission, goal)["goal_id"]
    joined = goal_of(api, goal)
    assert (joined["state"], joined["joint_goal"]) == ("waiting", own)
    with service.database.read() as session:
        assert session.get_one(GoalRow, goal).planned_by is None
    assert follow(mission, *ENDED)["joined_goals"] == [goal]
    carried_out = follow(f"/v1/goals/{goal}", "finished")
    assert (carried_out["outcome"], carried_out["plan_id"]) == ("completed", None)


def test_a_goal_that_has_joined_ends_once_its_part_is_done_and_counts_in_later_repairs(
    mission: str, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    goal = waiting(api, follow)
    team.faults.fails_at, team.faults.failures_left = dict.fromkeys(TEAM, "DOCK"), 1
    ask(api, mission, goal)
    ended = follow(mission, *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert [one["failure"] for one in ended["recovery"]["attempts"]] == [None, "robot"]
    assert goal_of(api, goal)["outcome"] == "completed"
    assert {fact["args"][0] for fact in api.get(f"/v1/plans/{ended['plan_id']}").json()["goals"]} == {
        "sample_1",
        "sample_4",
    }


def test_without_a_plan_for_it_the_goal_parts_and_the_mission_goes_on(
    mission: str, api: TestClient, follow: Follow
) -> None:
    goal = waiting(api, follow, "move sample_2 to bay_8")
    ask(api, mission, goal)
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["joined_goals"]) == ("completed", []), ended["reason"]
    first, second = ended["recovery"]["attempts"]
    assert (first["outcome"], first["goals"], second["outcome"], second["goals"]) == (
        "no plan",
        [goal],
        "approved",
        [],
    )
    assert first["detail"].startswith(f"there is no plan with {goal}: waits for store_1, which")
    assert second["reason"] == first["detail"]
    assert ended["recovery"]["tries_left"] == 4
    parted = follow(f"/v1/goals/{goal}", "waiting")
    assert parted["joint_goal"] is None
    assert "store_1, which administrator took out of service" in parted["reason"]


def test_a_plan_with_a_goal_waits_for_a_decision_and_once_rejected_the_goal_parts(
    start: Start, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    mission = under_way(start, api, team, "ask")
    goal = waiting(api, follow)
    ask(api, mission, goal)

    def deciding(now: Thing) -> bool:
        return bool(now["recovery"]["step"] == "deciding" or now["state"] in ENDED)

    plan = read_until(api, mission, deciding)["recovery"]["attempts"][-1]["plan_id"]
    assert len(api.get(f"/v1/plans/{plan}").json()["goals"]) == 2
    assert api.get(f"/v1/plans/{plan}/explanation").status_code == 200
    api.post(f"/v1/plans/{plan}:reject", json={}).raise_for_status()
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["joined_goals"]) == ("completed", [])
    assert follow(f"/v1/goals/{goal}", "planned", "waiting")["joint_goal"] is None
    assert follow(f"/v1/goals/{goal}", "planned")["joint_goal"] is None


def test_a_goal_that_has_joined_outlives_the_cancellation_of_the_mission(
    mission: str, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    goal = waiting(api, follow)
    team.faults.silent |= set(TEAM)
    ask(api, mission, goal)
    refused = api.post(f"/v1/goals/{goal}:cancel")
    assert refused.status_code == 409
    assert refused.json()["detail"].endswith(
        f"cancel mission {mission.rsplit('/', maxsplit=1)[-1]}, then the goal"
    )
    api.post(f"{mission}:cancel").raise_for_status()
    team.faults.silent.clear()
    assert follow(mission, *ENDED)["state"] == "cancelled"
    for robot in TEAM:
        api.post(f"/v1/robots/{robot}:bring_back")
    parted = follow(f"/v1/goals/{goal}", "planned")
    assert (parted["mission_id"], parted["joint_goal"]) == (None, None)


def test_a_goal_that_cannot_join_is_refused_with_the_reason(
    mission: str, api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    def refused(goal: str, status: int, code: str) -> str:
        answer = ask(api, mission, goal, status=status)
        assert answer["type"].rsplit(":")[-1] == code, answer
        return str(answer["detail"])

    own = api.get(mission).json()["goal_id"]
    assert "no goal" in refused("goal-0", 404, "unknown-goal")
    assert "is committed; only goals that wait" in refused(own, 409, "goal-not-waiting")
    late = waiting(api, follow, deadline_s=10_000)
    assert "times of its own" in refused(late, 422, "cannot-join")
    elsewhere = waiting(api, follow, "move sample_1 to bay_8")
    assert "sample_1" in refused(elsewhere, 409, "cannot-join")
    now = follow(mission, "running")
    assert (now["recovery"]["attempts"], now["revision"]) == ([], 1), "what is refused changes nothing"
    assert goal_of(api, elsewhere)["joint_goal"] is None
