"""Plans that count on robots' batteries, through the API with robots that finish at once."""

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.domain.plan_document import PlanBody
from planner import load_knowledge_base
from planner.engines.replenishment import ReplenishingEngine
from robots.wire import BehaviourScript
from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeTeam
from tests.app.planning.store_engine import StoreEngine
from tests.app.scripted import InProcessWorker

Follow = Callable[..., dict[str, Any]]
GOAL = {"text": "move sample_1 to bay_7"}
NUMBERS = "/v1/worlds/sample_store/numbers"


@pytest.fixture
def worker() -> InProcessWorker:
    return InProcessWorker(ReplenishingEngine(StoreEngine(), load_knowledge_base()))


@pytest.fixture
def world_file() -> WorldFile:
    """The sample store with robots whose batteries last for a minute or two."""
    world = load_world("sample_store")
    robots = tuple(robot.model_copy(update={"battery": 0.9, "battery_wh": 0.5}) for robot in world.robots)
    return world.model_copy(update={"robots": robots})


def state(api: TestClient, robot: str, level: float) -> None:
    number = {"quantity": "battery", "args": [robot], "value": level}
    answer = api.put(NUMBERS, json={"numbers": [number]})
    assert answer.status_code == 200, answer.text


def planned(api: TestClient, follow: Follow) -> dict[str, Any]:
    goal = follow(f"/v1/goals/{api.post('/v1/goals', json=GOAL).json()['id']}", "planned")
    return api.get(f"/v1/plans/{goal['plan_id']}").json()  # type: ignore[no-any-return]


def charges(plan: dict[str, Any]) -> dict[str, float]:
    return {one["agents"][0]: one["level"] for one in plan["actions"] if one["tag"] == "CHARGE"}


def test_a_robot_whose_battery_would_not_last_charges_first_for_as_long_as_the_plan_needs(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    assert charges(planned(api, follow)) == {}
    state(api, "store_2", 0.3)
    plan = planned(api, follow)
    assert charges(plan).keys() == {"store_2"}
    level = charges(plan)["store_2"]
    assert 0.3 < level <= 0.9
    approved = api.post(f"/v1/plans/{plan['id']}:approve", json={}).json()
    mission = follow(f"/v1/missions/{approved['mission_id']}", "completed", "failed")
    assert mission["state"] == "completed", mission
    script = team.robots["store_2"].script
    assert isinstance(script, BehaviourScript)
    (packet,) = [one for one in script.packets if one.tag == "RECHARGE"]
    assert packet.arguments["ref"] == "home_store_2"
    assert float(packet.arguments["to"]) == pytest.approx(level, abs=1e-3)


def test_a_plan_for_which_a_battery_no_longer_lasts_is_repaired(api: TestClient, follow: Follow) -> None:
    plan = planned(api, follow)
    state(api, "store_2", 0.3)
    (why,) = api.get(f"/v1/plans/{plan['id']}").json()["overtaken"]
    assert why.startswith("store_2's battery is at ")
    assert why.endswith("and plans keep it at 20 % or more")
    refused = api.post(f"/v1/plans/{plan['id']}:approve", json={})
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:plan-stale")
    goal = follow(f"/v1/goals/{plan['goal_id']}", "planned")
    repaired = api.get(f"/v1/plans/{goal['plan_id']}").json()
    assert charges(repaired).keys() == {"store_2"}
    assert repaired["overtaken"] == []


def test_the_level_is_kept_with_the_plan(api: TestClient, follow: Follow) -> None:
    state(api, "store_2", 0.3)
    plan = planned(api, follow)
    net = PlanBody.model_validate(
        {name: plan[name] for name in PlanBody.model_fields if name in plan}
    ).to_plan_net(load_knowledge_base())
    assert {one.agents[0]: one.level for one in net.actions if one.level is not None} == charges(plan)
