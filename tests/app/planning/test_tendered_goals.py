"""A goal put to tender, from its statement over the API to the end of its mission."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.domain.tender_document import Allocation
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import ConversationRow
from robots.wire import Performative
from robots.world import WorldFile
from tests.app.fake_robots import FakeRobot, FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import ENDED, read_until, until

pytestmark = ON_BOTH

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move sample_1 to bay_7", "allocation": "contract_net", "recovery": "auto"}


def bid(leg: str, cost_s: float) -> list[tuple[Performative, str]]:
    figures = f"cost({cost_s}), release(0), way(5), work({cost_s - 5}), battery(0.9)"
    return [(Performative.PROPOSE, f"bid({leg}, {figures})")]


def declined(leg: str) -> list[tuple[Performative, str]]:
    return [(Performative.REFUSE, f'declined({leg}, holds, "it holds a tool")')]


@pytest.fixture
def bidders(api: TestClient, team: FakeTeam) -> FakeTeam:
    team.faults.perceives = True
    let_bid(team)
    return team


def let_bid(team: FakeTeam) -> None:
    """yard_2 asks less than yard_1 for the first leg; store_2 alone bids for the second; the others decline."""
    costs = {("yard_1", "leg_1"): 60.0, ("yard_2", "leg_1"): 40.0, ("store_2", "leg_2"): 30.0}
    for robot in ("yard_1", "yard_2", "store_1", "store_2"):
        says = team.robots.setdefault(robot, FakeRobot()).says
        for leg in ("leg_1", "leg_2"):
            cost_s = costs.get((robot, leg))
            says[f"leg({leg}"] = declined(leg) if cost_s is None else bid(leg, cost_s)
            says[f"award({leg}"] = [(Performative.INFORM, f"done({leg})")]


def tendered(api: TestClient, follow: Follow) -> dict[str, Any]:
    """The plan of a goal that was put to tender."""
    stated = api.post("/v1/goals", json=GOAL)
    assert stated.status_code == 202, stated.text
    assert stated.json()["allocation"] == "contract_net"
    goal = follow(f"/v1/goals/{stated.json()['id']}", "planned", "unsolvable")
    assert goal["plan_id"] is not None, goal
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


def outcomes(api: TestClient, plan_id: str) -> dict[tuple[str, str], str]:
    tender = api.get(f"/v1/plans/{plan_id}/tender").json()
    return {
        (leg["id"], bid["robot"]): bid["outcome"]
        for leg in tender["legs"]
        for part in leg["parts"]
        for bid in part["bids"]
    }


def test_the_cheapest_bidders_do_the_legs_and_say_that_they_are_done(
    api: TestClient, follow: Follow, bidders: FakeTeam
) -> None:
    plan = tendered(api, follow)
    assert plan["robots"] == ["store_2", "yard_2"]
    teams = {leg["id"]: (leg["team"], leg["is_planned"]) for leg in plan["tender"]["legs"]}
    assert teams == {"leg_1": (["yard_2"], True), "leg_2": (["store_2"], True)}
    assert outcomes(api, plan["id"])["leg_1", "yard_1"] == "proposed"
    mission = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()["mission_id"]
    ended = follow(f"/v1/missions/{mission}", *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    done = read_until(
        api,
        f"/v1/plans/{plan['id']}/tender",
        lambda _: outcomes(api, plan["id"])["leg_2", "store_2"] == "done",
    )
    assert done["state"] == "awarded"
    assert outcomes(api, plan["id"]) == {
        ("leg_1", "yard_1"): "rejected",
        ("leg_1", "yard_2"): "done",
        ("leg_1", "store_1"): "refused",
        ("leg_1", "store_2"): "refused",
        ("leg_2", "yard_1"): "refused",
        ("leg_2", "yard_2"): "refused",
        ("leg_2", "store_1"): "refused",
        ("leg_2", "store_2"): "done",
    }
    until(lambda: any(said[0] == "reject-proposal" for said in bidders.robots["yard_1"].heard))
    said = [one["performative"] for one in api.get(f"/v1/missions/{mission}/conversation").json()["items"]]
    assert said.count("accept-proposal") == 2


def test_a_leg_whose_winner_fails_goes_to_the_next_best_bidder(
    api: TestClient, follow: Follow, bidders: FakeTeam, service: Service
) -> None:
    bidders.faults.fails_at = {"yard_2": "DOCK"}
    bidders.faults.takes_s["DOCK"] = 6.0
    bidders.robots["yard_2"].says["award(leg_1"] = [
        (Performative.FAILURE, 'failed(leg_1, "its script has failed")')
    ]
    plan = tendered(api, follow)
    mission = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()["mission_id"]
    ended = follow(f"/v1/missions/{mission}", *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    assert ended["revision"] == 2, "it is not tried again by the robot that has failed"
    again = api.get(f"/v1/plans/{ended['plan_id']}").json()
    assert "yard_1" in again["robots"]
    yard = again["tender"]["legs"][0]
    assert (yard["team"], yard["failed"], yard["is_planned"]) == (["yard_1"], ["yard_2"], True)
    assert "yard_2 failed at it" in yard["why"]
    assert outcomes(api, plan["id"])["leg_1", "yard_2"] == "failed"

    def awards() -> dict[str, str]:
        with service.database.read() as session:
            rows = session.query(ConversationRow).filter_by(about=mission, opener="awards").all()
            return {row.robot: row.state for row in rows}

    until(lambda: awards().get("yard_1") == "done")


def test_a_plan_that_was_not_put_to_tender_has_none(
    api: TestClient, follow: Follow, bidders: FakeTeam
) -> None:
    stated = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
    assert stated["allocation"] == "central"
    plan_id = follow(f"/v1/goals/{stated['id']}", "planned")["plan_id"]
    answer = api.get(f"/v1/plans/{plan_id}/tender")
    assert (answer.status_code, answer.json()["type"].rpartition(":")[2]) == (409, "not-tendered")
    assert api.get(f"/v1/plans/{plan_id}").json()["tender"] is None
    assert bidders.robots["yard_1"].heard == []


def test_a_cancelled_goal_rejects_the_bids(api: TestClient, follow: Follow, bidders: FakeTeam) -> None:
    plan = tendered(api, follow)
    api.post(f"/v1/goals/{plan['goal_id']}:cancel", json={})
    until(lambda: outcomes(api, plan["id"])["leg_1", "yard_2"] == "rejected")
    until(lambda: bidders.robots["yard_2"].heard[-1][0] == "reject-proposal")


def test_a_goal_that_robots_are_called_for_is_planned_after_a_restart_of_the_service(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> None:
    settings = Settings(data=tmp_path, token="a-token-for-the-restart", database_url=database_url)

    def started() -> Service:
        world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
        return Service(settings, [world], worker=worker)

    with started() as service:
        request = GoalRequest(
            world=world_file.name, text="move sample_1 to bay_7", allocation=Allocation.CONTRACT_NET
        )
        goal_id = service.goals.submit(request, actor="operator").id
        until(lambda: service.goals.get(goal_id).reason == "robots are called for proposals")
    let_bid(team)
    with started() as service:
        until(lambda: service.goals.get(goal_id).state == "planned")
        plan_id = service.goals.get(goal_id).plan_id
        assert plan_id is not None
        assert service.plans.get(plan_id).body["robots"] == ["store_2", "yard_2"]
