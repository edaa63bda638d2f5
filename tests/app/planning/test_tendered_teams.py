"""A joint task put to tender: the cheapest pair of bidders does it, and the next one if a member refuses."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from planner import load_knowledge_base
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from robots.wire import Performative
from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeRobot, FakeTeam
from tests.app.scripted import InProcessWorker
from tests.waiting import ENDED

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move rock_sample to lander", "allocation": "contract_net", "recovery": "auto"}


@pytest.fixture(scope="module")
def worker() -> InProcessWorker:
    return InProcessWorker(HierarchicalEngine(load_knowledge_base()))


@pytest.fixture
def world_file() -> WorldFile:
    """The relocation laboratory with a third robot, which begins far from the sample."""
    world = load_world("relocation_lab").model_dump()
    home = {"name": "home_rose", "kind": "home", "at": (9.9, 6.2), "approach_deg": (180,), "capacity": 0}
    ginger = next(one for one in world["robots"] if one["name"] == "ginger")
    rose = {**ginger, "name": "rose", "start": (9.1, 6.2, 0.0), "home": "home_rose"}
    world["locations"] = [*world["locations"], home]
    world["robots"] = [*world["robots"], rose]
    return WorldFile.model_validate(world)


def bid(cost_s: float) -> list[tuple[Performative, str]]:
    figures = f"cost({cost_s}), release(0), way({cost_s - 50}), work(50), battery(0.9)"
    return [(Performative.PROPOSE, f"bid(leg_1, {figures})")]


@pytest.fixture
def bidders(api: TestClient, team: FakeTeam) -> FakeTeam:
    """rose and ginger ask less than fred."""
    team.faults.perceives = True
    for robot, cost_s in {"fred": 90.0, "ginger": 60.0, "rose": 70.0}.items():
        says = team.robots.setdefault(robot, FakeRobot()).says
        says["leg"] = bid(cost_s)
        says["award"] = [(Performative.INFORM, "done(leg_1)")]
    return team


def planned(api: TestClient, follow: Follow) -> dict[str, Any]:
    stated = api.post("/v1/goals", json=GOAL)
    assert stated.status_code == 202, stated.text
    goal = follow(f"/v1/goals/{stated.json()['id']}", "planned", "unsolvable")
    assert goal["plan_id"] is not None, goal
    plan: dict[str, Any] = api.get(f"/v1/plans/{goal['plan_id']}").json()
    return plan


def test_the_pair_that_costs_least_together_is_awarded_a_joint_leg(
    api: TestClient, follow: Follow, bidders: FakeTeam
) -> None:
    plan = planned(api, follow)
    (leg,) = plan["tender"]["legs"]
    assert (set(leg["team"]), leg["is_planned"]) == ({"ginger", "rose"}, True)
    assert plan["robots"] == ["ginger", "rose"]
    assert [part["tags"][0] for part in leg["parts"]] == ["DOCK", "DOCK2"]
    assert "the next best, " in leg["why"]
    assert "fred" in leg["why"]


def test_when_a_member_refuses_the_next_team_is_formed(
    api: TestClient, follow: Follow, bidders: FakeTeam
) -> None:
    bidders.faults.refuses = {"rose"}
    plan = planned(api, follow)
    mission = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()["mission_id"]
    ended = follow(f"/v1/missions/{mission}", *ENDED)
    assert ended["state"] == "completed", ended["reason"]
    again = api.get(f"/v1/plans/{ended['plan_id']}").json()
    (leg,) = again["tender"]["legs"]
    assert (set(leg["team"]), leg["failed"], leg["is_planned"]) == ({"fred", "ginger"}, ["rose"], True)
    assert again["robots"] == ["fred", "ginger"]
