"""Goals that wait are carried out together by a goal that the service states."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.domain.blockers import Blockers
from app.domain.world_model import planning_problem
from app.domain.world_model.reservation import Reservation, is_withheld
from app.planning.pool.joint import JointWork, Together
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.withheld import Withheld
from app.planning.waiting_goals import STATED_BY
from planner import UNOBSERVED, KnowledgeBase, PlanningRequest
from tests.app.fake_robots import FakeTeam
from tests.app.planning.store_engine import StoreEngine
from tests.app.sample_store import Store
from tests.app.scripted import InProcessWorker
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
TEAM = ["yard_1", "yard_2", "store_1", "store_2"]
TEXTS = {"sample_1": "move sample_1 to bay_7", "sample_2": "move sample_2 to interchange_1"}


def submit(api: TestClient, text: str, **more: Any) -> str:
    answer = api.post("/v1/goals", json={"text": text, "auto_approve": True, **more})
    assert answer.status_code == 202, answer.text
    return f"/v1/goals/{answer.json()['id']}"


def waiting(api: TestClient, follow: Follow, *goals: str | dict[str, Any]) -> list[str]:
    """Goals that wait for the robots, which are out of service."""
    api.post("/v1/robots:take_out_of_service", json={"robots": TEAM, "reason": "snow"}).raise_for_status()
    submitted = [submit(api, **({"text": goal} if isinstance(goal, str) else goal)) for goal in goals]
    for goal in submitted:
        follow(goal, "waiting")
    return submitted


def bring_back(api: TestClient) -> None:
    api.post("/v1/robots:bring_back", json={"robots": TEAM}).raise_for_status()


def stated(api: TestClient) -> list[dict[str, Any]]:
    """The goals that the service has stated, newest first."""
    found = api.get("/v1/goals").raise_for_status().json()["items"]
    return [goal for goal in found if goal["created_by"] == STATED_BY]


@ON_BOTH
def test_goals_that_wait_are_carried_out_together_by_one_mission(api: TestClient, follow: Follow) -> None:
    goals = waiting(api, follow, *TEXTS.values())
    bring_back(api)
    for goal in goals:
        ended = follow(goal, "finished")
        (joint,) = stated(api)
        assert ended["outcome"] == "completed"
        assert ended["reason"] == f"carried out together with others by {joint['mission_id']}"
        assert ended["joint_goal"] == joint["id"]
        assert (ended["plan_id"], ended["mission_id"]) == (None, joint["mission_id"])
    joint = follow(f"/v1/goals/{joint['id']}", "finished")
    assert joint["outcome"] == "completed"
    assert joint["text"] == " and ".join(TEXTS.values())
    assert [fact["args"][0] for fact in joint["goal"]] == list(TEXTS)
    assert len(api.get("/v1/missions").json()["items"]) == 1


def test_what_is_to_be_done_each_time_was_done_by_the_mission_that_carried_it_out(
    api: TestClient, follow: Follow, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(KnowledgeBase, "achieved_each_time", lambda _, facts: frozenset(facts))
    goals = waiting(api, follow, *TEXTS.values())
    bring_back(api)
    for goal in goals:
        assert follow(goal, "finished")["reason"].startswith("carried out together")
    assert len(api.get("/v1/missions").json()["items"]) == 1


@ON_BOTH
def test_a_goal_ends_once_its_part_is_done_while_the_mission_goes_on(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_2")
    goals = waiting(api, follow, TEXTS["sample_1"], TEXTS["sample_2"])
    bring_back(api)
    ended = follow(goals[1], "finished")
    (joint,) = stated(api)
    assert (joint["state"], ended["mission_id"]) == ("committed", joint["mission_id"])
    assert ended["reason"] == f"carried out together with others by {joint['mission_id']}"
    assert api.get(goals[0]).json()["state"] == "waiting"
    team.faults.stuck.clear()
    for goal in (goals[0], f"/v1/goals/{joint['id']}"):
        assert follow(goal, "finished")["outcome"] == "completed"


def test_what_was_done_before_the_mission_was_cancelled_stays_done(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("store_2")
    goals = waiting(api, follow, *TEXTS.values())
    bring_back(api)
    mission = follow(goals[1], "finished")["mission_id"]
    api.post(f"/v1/missions/{mission}:cancel", json={}).raise_for_status()
    team.faults.stuck.clear()
    assert follow(goals[0], "withdrawn")["outcome"] == "cancelled"
    assert api.get(goals[1]).json()["outcome"] == "completed"


def test_a_goal_that_another_carries_out_waits_for_it_and_is_cancelled_by_its_mission(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.update(("yard_1", "store_1"))
    goals = waiting(api, follow, *TEXTS.values())
    bring_back(api)
    until(lambda: stated(api))
    (joint,) = stated(api)
    mission = follow(f"/v1/goals/{joint['id']}", "committed")["mission_id"]
    reason = api.get(goals[0]).json()["reason"]
    assert reason == f"waits for {joint['id']}, which carries it out together with another"
    refusal = api.post(f"{goals[0]}:cancel", json={})
    assert refusal.status_code == 409
    assert f"cancel mission {mission}" in refusal.json()["detail"]
    api.post("/v1/robots/yard_2:take_out_of_service", json={"reason": "snow"}).raise_for_status()  # a release
    api.post(f"/v1/missions/{mission}:cancel", json={}).raise_for_status()
    team.faults.stuck.clear()
    follow(f"/v1/missions/{mission}", "cancelled")
    for goal in goals:
        ended = follow(goal, "withdrawn")
        assert ended["outcome"] == "cancelled"
        assert ended["reason"] == f"{joint['id']}, which carried it out together with others, was cancelled"


def test_what_a_failed_mission_has_not_done_is_planned_by_itself(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.fails_at = dict.fromkeys(TEAM, "NAVIGATE")
    goals = waiting(api, follow, *TEXTS.values())
    bring_back(api)
    until(lambda: stated(api))
    (joint,) = stated(api)
    assert follow(f"/v1/goals/{joint['id']}", "finished")["outcome"] == "failed"
    for goal in goals:
        ended = follow(goal, "finished")
        assert ended["outcome"] == "failed"
        assert ended["mission_id"] not in (None, joint["mission_id"])
    assert len(stated(api)) == 1


@pytest.mark.parametrize(
    "other",
    [
        {"auto_approve": False},
        {"deadline_s": 900.0},
        {"priority": 1},
        {"recovery": "ask"},
        {"effort_s": 3.0},
        {"constraints": {"without": ["store_2"]}},
        {"allocation": "contract_net"},
    ],
    ids=str,
)
def test_goals_that_ask_for_something_of_their_own_are_planned_by_themselves(
    api: TestClient, follow: Follow, other: dict[str, Any]
) -> None:
    goals = waiting(api, follow, TEXTS["sample_1"], {"text": TEXTS["sample_2"], **other})
    bring_back(api)
    ends = ("finished", "planned") if not other.get("auto_approve", True) else ("finished",)
    for goal in goals:
        assert follow(goal, *ends)["joint_goal"] is None
    assert stated(api) == []


def test_goals_that_cannot_both_come_true_are_not_planned_together(api: TestClient, follow: Follow) -> None:
    goals = waiting(api, follow, TEXTS["sample_1"], "move sample_2 to bay_7")
    bring_back(api)
    assert follow(goals[0], "finished")["mission_id"] is not None
    until(lambda: api.get(goals[1]).json()["state"] != "planning")
    assert stated(api) == []


def test_of_goals_of_which_one_is_withdrawn_meanwhile_none_are_joined(
    api: TestClient, follow: Follow, worker: "Watched"
) -> None:
    goals = waiting(api, follow, *TEXTS.values())
    worker.meanwhile = lambda: api.post(f"{goals[1]}:cancel", json={}).raise_for_status()
    bring_back(api)
    assert follow(goals[0], "finished")["mission_id"] is not None
    assert follow(goals[1], "withdrawn")["outcome"] == "cancelled"
    assert stated(api) == []


STORE = Store()


def work_on(*goals: str, at_most: int = 4, **reserved: str) -> Together:
    """What comes of goals of one fact each while missions have reserved robots, by the mission's name."""
    facts = [STORE.fact(goal) for goal in goals]
    whole = planning_problem(STORE.world, STORE.facts, facts)
    missions = {name: Reservation(robots=frozenset({robot})) for name, robot in reserved.items()}
    left = frozenset(
        fact for fact in whole.facts if not any(is_withheld(fact, one) for one in missions.values())
    )
    result = JointWork(
        knowledge_base=STORE.base,
        problem=replace(whole, facts=left),
        withheld=Withheld(whole=whole, missions=missions, robots={}),
        request=PlanningRequest(time_limit_s=10),
        parts=[(fact,) for fact in facts],
        at_most=at_most,
    )(StoreEngine(), UNOBSERVED)
    assert result.answer is not None
    return result.answer


def test_what_is_within_reach_is_planned_together_and_what_is_not_says_what_it_waits_for() -> None:
    goals = ("in(sample_1, bay_7)", "in(sample_2, interchange_1)", "in(sample_4, bay_10)")
    free = work_on(*goals)
    assert free.joined == (0, 1, 2)
    assert free.solution is not None
    assert free.solution.result.plan_net is not None
    assert {str(goal) for goal in free.solution.result.plan_net.goals} == {
        str(STORE.fact(one)) for one in goals
    }
    assert free.waiting == {}
    assert work_on(*goals, at_most=2).joined == (0, 1)
    none = work_on(*goals, a="yard_1", b="yard_2", c="store_1", d="store_2")
    assert none.solution is None
    assert none.waiting.keys() == {0, 1, 2}
    assert all(none.waiting[n] for n in none.waiting)


def test_a_goal_waits_for_the_missions_that_stand_in_its_way_alone() -> None:
    goals = ("in(sample_1, interchange_1)", "in(sample_2, interchange_1)")
    found = work_on(*goals, a="store_1", b="store_2", c="yard_1")
    in_store = [n for n in (0, 1) if n in found.waiting]
    assert in_store, "one of the samples lies in the store"
    for n in in_store:
        assert found.waiting[n] in (Blockers(missions=("a",)), Blockers(missions=("b",)))


def test_a_joint_plan_that_is_out_of_date_leaves_no_trace(
    api: TestClient, follow: Follow, worker: "Watched"
) -> None:
    goals = waiting(api, follow, *TEXTS.values())
    told = "/v1/worlds/sample_store/facts"
    moved = {"facts": [{"predicate": "in", "args": ["sample_2", "bay_1"]}]}
    worker.meanwhile = lambda: api.put(told, json=moved).raise_for_status()
    bring_back(api)
    for goal in goals:
        assert follow(goal, "finished", "unsolvable")["joint_goal"] is None
    assert stated(api) == []


class Watched(InProcessWorker):
    """Plans in the process of the test; `meanwhile` happens during the next planning of several goals."""

    def __init__(self) -> None:
        super().__init__(StoreEngine())
        self.meanwhile: Callable[[], object] | None = None

    def do(self, work: Any, *args: Any, **more: Any) -> Any:
        if isinstance(work, JointWork) and self.meanwhile is not None:
            meanwhile, self.meanwhile = self.meanwhile, None
            meanwhile()
        return super().do(work, *args, **more)


@pytest.fixture
def worker() -> PlanningWorker:
    return Watched()
