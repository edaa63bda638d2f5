"""A mission under way is looked at again when a robot becomes available; what that would save is told."""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.missions import better_plans
from app.missions.better_plans import AGAIN_AFTER_S, MIN_SHARE, STOP_S, BetterPlans, saving_s
from app.missions.replanning import MissionPreview
from tests.app.fake_robots import FakeTeam
from tests.app.missions.recovery.conftest import Follow, Start
from tests.app.stepped_clock import SteppedClock
from tests.databases import ON_BOTH
from tests.waiting import ENDED, read_until, until

Thing = dict[str, Any]
FOR_EVER_S = 1_000_000.0
OTHER = {"yard_1": "yard_2", "yard_2": "yard_1"}


def under_way(start: Start, api: TestClient, team: FakeTeam) -> tuple[str, str]:
    """A mission whose yard robot carries its sample, and the other yard robot, which is out of service."""
    team.faults.takes_s = {"TRANSPORT": FOR_EVER_S}
    mission, yard = start("auto")
    until(lambda: yard in team.robots and team.robots[yard].left_s > FOR_EVER_S / 2)
    rest = api.post(f"/v1/robots/{OTHER[yard]}:take_out_of_service", json={"reason": "it charges"})
    rest.raise_for_status()
    return mission, OTHER[yard]


def bring_back(api: TestClient, robot: str) -> None:
    api.post(f"/v1/robots/{robot}:bring_back").raise_for_status()


@ON_BOTH
def test_a_better_plan_is_offered_and_made_only_if_the_operator_asks(
    start: Start,
    api: TestClient,
    follow: Follow,
    team: FakeTeam,
    service: Service,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(better_plans, "STOP_S", -FOR_EVER_S)  # any other plan pays
    mission, robot = under_way(start, api, team)
    assert api.get(mission).json()["better_plan"] is None
    bring_back(api, robot)
    offered = read_until(api, mission, lambda one: one["better_plan"] and one["state"] == "running")
    assert offered["recovery"]["attempts"] == []
    better = offered["better_plan"]
    assert better["saves_s"] > 0
    (told,) = [row for row in service.events.since(0) if row.type == "mission.better_plan_found"]
    assert (told.subject, told.data["robots"]) == (offered["id"], better["robots"])
    team.faults.takes_s = {}
    api.post(f"{mission}:replan").raise_for_status()
    assert api.get(mission).json()["better_plan"] is None
    ended = follow(mission, *ENDED)
    assert (ended["state"], ended["better_plan"]) == ("completed", None)


def test_a_world_whose_robots_come_and_go_is_looked_at_once_a_minute(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = SteppedClock()
    sought: list[str] = []
    plans = BetterPlans(service.core, replanning=service.replanning, clock=clock)
    monkeypatch.setattr(plans, "seek", lambda session, world: sought.append(world))
    plans.follow("sample_store")
    assert sought == [], "no robot became available"
    for _ in range(3):
        plans.robot_available("sample_store")
        plans.follow("sample_store")
    assert sought == ["sample_store"]
    clock.advance(AGAIN_AFTER_S)
    plans.follow("sample_store")
    plans.follow("sample_store")
    assert sought == ["sample_store"] * 2


def preview(*, ends_in_s: float | None, expected_in_s: float | None) -> MissionPreview:
    return MissionPreview(plan_id="plan-1", made_at_s=0.0, ends_in_s=ends_in_s, expected_in_s=expected_in_s)


@pytest.mark.parametrize(
    ("ends_in_s", "expected_in_s", "saved_s"),
    [
        (None, 100.0, None),
        (50.0, None, None),
        (100.0, 100.0, None),
        (100.0 - STOP_S - 100.0 * MIN_SHARE, 100.0, None),
        (50.0, 100.0, 50.0 - STOP_S),
    ],
    ids=["no plan", "not begun", "the same", "just not worth it", "worth it"],
)
def test_a_better_plan_saves_a_tenth_of_the_time_and_the_stop(
    ends_in_s: float | None, expected_in_s: float | None, saved_s: float | None
) -> None:
    assert saving_s(preview(ends_in_s=ends_in_s, expected_in_s=expected_in_s)) == saved_s
