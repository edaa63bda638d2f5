"""Facts that are kept true by holds: what other goals are told, what waits, and what is done once one is lost."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy.exc import OperationalError

from app.composition import Service
from app.store import GoalRow
from tests.app.fake_robots import FakeTeam
from tests.app.planning.test_holds import HOLDS, approve, correct, end, refusal, standing, state
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
NOTICE = "keep sample_2 in bay_2 until further notice"
LIES = {"predicate": "in", "args": ["sample_2", "bay_2"]}


def facts_of(goal: dict[str, Any]) -> list[str]:
    return [f"{one['predicate']}({', '.join(one['args'])})" for one in goal["goal"]]


def told(service: Service, kind: str) -> list[dict[str, Any]]:
    return [event.data for event in service.events.since(0) if event.type == kind]


def lose(api: TestClient) -> str:
    """Put sample_2 elsewhere; the goal that is to bring it back."""
    correct(api, "in", "sample_2", "bay_3")
    until(lambda: [one["goal"] for one in standing(api)[0]["lost"]] not in ([], [None]))
    goal: str = standing(api)[0]["lost"][0]["goal"]
    return goal


@ON_BOTH
def test_keeping_what_is_true_is_done_at_once_and_stands(api: TestClient, service: Service) -> None:
    goal = state(api, "keep sample_2 in bay_2 and yard_1 at home_yard_1 for ten minutes")
    assert (goal["state"], goal["outcome"], goal["goal"]) == ("finished", "completed", [])
    assert goal["reason"].startswith("nothing to carry out; holds sample_2 in bay_2 for 10 min")
    robot, sample = standing(api)
    assert (sample["facts"], sample["words"], sample["lost"]) == ([LIES], "sample_2 in bay_2", [])
    assert (robot["places"], robot["words"]) == ([], "yard_1 at home_yard_1")
    assert [one["facts"] for one in told(service, "hold.began")] == [
        ["in(sample_2, bay_2)"],
        ["near(yard_1, home_yard_1)"],
    ]


def test_a_goal_that_ends_a_kept_fact_is_told_of_the_hold_its_end_and_how_to_end_it(api: TestClient) -> None:
    state(api, NOTICE)
    (hold,) = standing(api)
    for text in ("move sample_2 to bay_3", "move all samples of aisle_1 to any bay of aisle_2"):
        problem = refusal(api, text=text)
        assert (problem["status"], problem["code"], problem["thing"]) == (409, "fact-held", "sample_2")
        assert f"hold {hold['id']} keeps sample_2 in bay_2 until an operator ends it" in problem["detail"]
        assert f"POST {HOLDS}/{hold['id']}:end" in problem["detail"]
        assert api.post("/v1/goals:check", json={"text": text}).json()["issue"]["code"] == "fact-held"
    assert facts_of(state(api, "move any sample of aisle_1 to bay_7")) == ["in(sample_3, bay_7)"]
    end(api)
    state(api, "move sample_2 to bay_3")


def test_a_robot_that_is_kept_goes_nowhere_else_and_others_do_its_work(
    api: TestClient, follow: Follow
) -> None:
    state(api, "keep yard_1 at home_yard_1 until further notice")
    assert refusal(api, text="send yard_1 to door_2")["code"] == "fact-held"
    goal = f"/v1/goals/{state(api, 'move sample_1 to bay_7')['id']}"
    plan = api.get(f"/v1/plans/{follow(goal, 'planned')['plan_id']}").json()
    assert "yard_1" not in plan["robots"]


@ON_BOTH
def test_what_is_not_true_yet_is_brought_about_by_the_goal_and_kept_from_the_start(
    api: TestClient, follow: Follow
) -> None:
    goal = state(api, "keep sample_1 in bay_7 for two hours")
    assert facts_of(goal) == ["in(sample_1, bay_7)"]
    assert refusal(api, text="move sample_1 to bay_3")["code"] == "fact-held"
    assert refusal(api, text="move sample_2 to bay_7")["code"] == "fact-held"
    assert facts_of(state(api, "move sample_4 to any bay of aisle_2")) == ["in(sample_4, bay_8)"]
    mission = approve(api, follow(f"/v1/goals/{goal['id']}", "planned")["plan_id"])
    follow(f"/v1/missions/{mission}", "completed")
    assert refusal(api, text="move sample_1 to bay_3")["code"] == "fact-held"


def test_an_open_plan_that_ends_the_fact_is_out_of_date_and_its_goal_waits_for_the_end(
    api: TestClient, follow: Follow
) -> None:
    earlier = f"/v1/goals/{state(api, 'move sample_2 to bay_3')['id']}"
    plan = follow(earlier, "planned")["plan_id"]
    state(api, NOTICE)
    (hold,) = standing(api)
    why = f"hold {hold['id']} keeps sample_2 in bay_2 until an operator ends it"
    assert why in api.get(f"/v1/plans/{plan}").json()["overtaken"]
    assert api.post(f"/v1/plans/{plan}:approve", json={}).status_code == 409
    waiting = follow(earlier, "waiting")
    assert waiting["reason"].startswith(
        f"waits for the end of hold {hold['id']}, which keeps sample_2 in bay_2"
    )
    end(api)
    approve(api, follow(earlier, "planned")["plan_id"])


def test_a_hold_that_a_running_mission_stands_against_is_refused_with_the_mission(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_2")
    goal = f"/v1/goals/{state(api, 'move sample_1 to bay_7')['id']}"
    mission = approve(api, follow(goal, "planned")["plan_id"])
    for text, thing in (
        ("keep sample_1 in bay_3 for an hour", "sample_1"),
        ("keep store_2 at home_store_2 for an hour", "store_2"),
        ("keep sample_2 in bay_7 for an hour", "bay_7"),
    ):
        problem = refusal(api, text=text)
        assert (problem["code"], problem["thing"]) == ("needed-by-mission", thing)
        assert mission in problem["detail"]
    assert standing(api) == []
    kept = state(api, "keep sample_1 in bay_7 until further notice")
    team.faults.stuck.clear()
    follow(f"/v1/missions/{mission}", "completed")
    goal = follow(f"/v1/goals/{kept['id']}", "finished")
    assert (goal["outcome"], goal["plan_id"]) == ("completed", None), "it is true already"
    assert [one["lost"] for one in standing(api)] == [[]]


@ON_BOTH
def test_what_ceases_to_be_true_is_told_once_and_a_goal_that_restores_it_is_proposed(
    api: TestClient, service: Service, follow: Follow
) -> None:
    state(api, NOTICE, priority=3)
    (hold,) = standing(api)
    correct(api, "in", "sample_2", "bay_3")
    until(lambda: [one["goal"] for one in standing(api)[0]["lost"]] not in ([], [None]))
    (lost,) = standing(api)[0]["lost"]
    assert (lost["fact"], lost["now"]) == (LIES, "sample_2 is in bay_3")
    goal = follow(f"/v1/goals/{lost['goal']}", "planned")
    assert (facts_of(goal), goal["created_by"], goal["priority"]) == (["in(sample_2, bay_2)"], hold["id"], 3)
    assert not goal["auto_approve"]
    assert refusal(api, text="move sample_2 to bay_4")["code"] == "fact-held"
    mission = approve(api, goal["plan_id"])
    follow(f"/v1/missions/{mission}", "completed")
    until(lambda: standing(api)[0]["lost"] == [])
    world = {"world": "sample_store", "fact": "in(sample_2, bay_2)"}
    assert told(service, "hold.fact_lost") == [{**world, "now": "sample_2 is in bay_3"}]
    assert told(service, "hold.fact_restored") == [world]
    assert told(service, "hold.restoring") == [{"world": "sample_store", "goal": goal["id"], "reason": ""}]


def test_a_goal_that_restores_is_approved_by_itself_only_if_the_stating_goal_was(
    api: TestClient, follow: Follow
) -> None:
    state(api, NOTICE, auto_approve=True)
    correct(api, "in", "sample_2", "bay_3")
    until(lambda: [one["goal"] for one in standing(api)[0]["lost"]] not in ([], [None]))
    goal = follow(f"/v1/goals/{standing(api)[0]['lost'][0]['goal']}", "finished")
    assert goal["auto_approve"]
    until(lambda: standing(api)[0]["lost"] == [])


def test_a_goal_is_withdrawn_once_not_needed_and_what_cannot_be_restored_is_told_and_tried_again(
    api: TestClient, service: Service, follow: Follow
) -> None:
    state(api, NOTICE)
    goal = lose(api)
    follow(f"/v1/goals/{goal}", "planned")  # while it is planned it may also end by itself: true already
    correct(api, "in", "sample_2", "bay_2")
    until(lambda: standing(api)[0]["lost"] == [])
    until(lambda: api.get(f"/v1/goals/{goal}").json()["outcome"] == "cancelled")
    assert api.get(f"/v1/goals/{goal}").json()["reason"] == "cancelled: in(sample_2, bay_2) is true again"
    correct(api, "in", "sample_1", "bay_2")  # what lay there is now in an unknown place
    until(lambda: [one["reason"] for one in standing(api)[0]["lost"]] not in ([], [""]))
    (lost,) = standing(api)[0]["lost"]
    assert (lost["goal"], lost["now"]) == (None, "sample_2 is in an unknown place")
    assert "bay_2 is occupied by sample_1" in lost["reason"]
    facts = [{"predicate": "in", "args": args} for args in (["sample_1", "door_1"], ["sample_2", "bay_3"])]
    api.put("/v1/worlds/sample_store/facts", json={"facts": facts}).raise_for_status()
    until(lambda: [one["goal"] for one in standing(api)[0]["lost"]] not in ([], [None]))
    assert [one["goal"] is None for one in told(service, "hold.restoring")] == [False, True, False]


def test_a_withdrawal_that_fails_is_made_up_for(
    api: TestClient, service: Service, follow: Follow, monkeypatch: pytest.MonkeyPatch
) -> None:
    state(api, NOTICE)
    goal = lose(api)
    follow(f"/v1/goals/{goal}", "planned")
    cancel = service.goals.cancel
    failures = iter([OperationalError("UPDATE goals", {}, Exception("database is locked"))])

    def fail_once(*args: Any, **options: Any) -> GoalRow:
        for failure in failures:
            raise failure
        return cancel(*args, **options)

    monkeypatch.setattr(service.goals, "cancel", fail_once)
    correct(api, "in", "sample_2", "bay_2")
    assert follow(f"/v1/goals/{goal}", "withdrawn")["outcome"] == "cancelled"
    assert next(failures, None) is None


def test_holds_of_places_and_of_facts_are_stated_together_and_alone(api: TestClient) -> None:
    hold = {"places": ["bay_8"], "facts": [LIES], "until": {"in_s": 600}}
    alone = api.post("/v1/goals", json={"holds": [hold]}, headers={"idempotency-key": "k"}).json()
    assert (alone["state"], alone["text"]) == (
        "finished",
        "keep bay_8 empty and sample_2 in bay_2 for 10 min of the world's clock",
    )
    again = api.post("/v1/goals", json={"holds": [hold]}, headers={"idempotency-key": "k"})
    assert (again.status_code, again.json()["id"]) == (202, alone["id"])
    assert [(one["places"], one["facts"]) for one in standing(api)] == [(["bay_8"], [LIES])]
    checked = api.post("/v1/goals:check", json={"text": "keep sample_4 in bay_11 until 14:30"}).json()
    assert checked["holds"][0]["facts"] == [{"predicate": "in", "args": ["sample_4", "bay_11"]}]
    assert checked["holds"][0]["words"].startswith("will hold sample_4 in bay_11 until ")


@pytest.mark.parametrize(
    ("holds", "code"),
    [
        ([{"facts": [{"predicate": "in", "args": ["sample_9", "bay_7"]}]}], "unknown-sample"),
        ([{"facts": [{"predicate": "in", "args": ["sample_1", "bay_77"]}]}], "unknown-place"),
        ([{"facts": [{"predicate": "near", "args": ["sample_1", "bay_7"]}]}], "unknown-robot"),
        ([{"facts": [{"predicate": "vacant", "args": ["bay_7"]}]}], "fact-not-kept"),
        ([{"facts": [{"predicate": "in", "args": ["sample_1"]}]}], "malformed-fact"),
        ([{"facts": [], "until": {"in_s": 5}}], "malformed-request"),
        ([{"facts": [LIES], "until": {"in_s": 0}}], "malformed-request"),
        (
            [{"facts": [LIES, {"predicate": "in", "args": ["sample_2", "bay_3"]}]}],
            "constraint-contradicts-goal",
        ),
        ([{"places": ["bay_2"], "facts": [LIES]}], "constraint-contradicts-goal"),
    ],
)
def test_a_hold_that_cannot_be_is_refused(api: TestClient, holds: list[Any], code: str) -> None:
    assert refusal(api, holds=holds)["code"] == code
    assert standing(api) == []


def test_holds_that_contradict_each_other_are_refused(api: TestClient) -> None:
    state(api, NOTICE)
    assert refusal(api, text="keep bay_2 empty for an hour")["code"] == "fact-held"
    assert refusal(api, text="keep sample_2 in bay_3 for an hour")["code"] == "fact-held"
    end(api)
    state(api, "keep bay_2 empty for an hour")
    assert refusal(api, holds=[{"facts": [LIES]}])["code"] == "place-held"
