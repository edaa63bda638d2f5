"""Robots whose battery is low, or that charge on their own account, are not recruited."""

from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.agents import RobotBoard
from robots.clock import ManualClock
from robots.wire import OWN, Telemetry
from tests.app.fake_robots import FakeTeam
from tests.waiting import in_state, read_until

Thing = dict[str, Any]
RECHARGE = f"{OWN}:1"
"""A script of the robot's own, by which it is charged."""


def post(api: TestClient, text: str) -> str:
    return f"/v1/goals/{api.post('/v1/goals', json={'text': text}).json()['id']}"


def settled(goal: Thing) -> bool:
    return goal["state"] in ("waiting", "planned", "unsolvable")


def said(battery: float, *, charging: bool = False, script_id: str | None = None) -> Telemetry:
    return Telemetry(
        at_s=0.0,
        x_m=0.0,
        y_m=0.0,
        heading_rad=0.0,
        battery=battery,
        charging=charging,
        script_id=script_id,
    )


def test_a_goal_waits_for_a_robot_with_a_low_battery_until_it_has_charged(
    api: TestClient, team: FakeTeam
) -> None:
    team.tell("store_2", battery=0.1)
    read_until(api, "/v1/robots/store_2", lambda robot: robot["battery"] == 0.1)
    goal = post(api, "move sample_4 to bay_8")
    waiting = read_until(api, goal, settled)
    assert (waiting["state"], waiting["reason"]) == (
        "waiting",
        "waits for store_2, which rests, its battery at 10%",
    )
    team.tell("store_2", battery=0.5, charging=True, script_id=RECHARGE)
    read_until(api, "/v1/robots/store_2", lambda robot: robot["battery"] == 0.5)
    followed = read_until(api, goal, lambda now: "50%" in now["reason"])
    assert (followed["state"], followed["reason"]) == (
        "waiting",
        "waits for store_2, which charges, its battery at 50%",
    )
    team.tell("store_2", battery=0.9)
    assert in_state(api, goal, "planned", "unsolvable")["state"] == "planned"


def test_another_robot_is_recruited_instead_of_one_that_charges(api: TestClient, team: FakeTeam) -> None:
    team.tell("yard_1", battery=0.8, charging=True, script_id=RECHARGE)
    read_until(api, "/v1/robots/yard_1", lambda robot: robot["battery"] == 0.8)
    goal = read_until(api, post(api, "move sample_1 to bay_7"), settled)
    assert "yard_2" in api.get(f"/v1/plans/{goal['plan_id']}").json()["robots"]


@pytest.mark.parametrize(
    ("told", "is_unavailable"),
    [
        ([said(0.2)], False),
        ([said(0.19)], True),
        ([said(0.19), said(0.24)], True),
        ([said(0.19), said(0.26)], False),
        ([said(0.19), said(0.24, charging=True)], True),
        ([said(0.6, charging=True)], False),
        ([said(0.6, charging=True, script_id=RECHARGE)], True),
        ([said(0.6, charging=True, script_id=RECHARGE), said(0.6, charging=True)], False),
    ],
)
def test_a_robot_at_the_mark_is_not_called_fit_and_unfit_by_turns(
    told: list[Telemetry], is_unavailable: bool
) -> None:
    board = RobotBoard([("yard_1", "store")], clocks={"store": ManualClock()}, low_battery=0.2)
    for telemetry in told:
        board.heard("yard_1", telemetry)
    assert bool(board.unavailable("store")) is is_unavailable


def test_the_world_of_a_robot_that_is_fit_again_is_notified_once() -> None:
    board = RobotBoard([("yard_1", "store")], clocks={"store": ManualClock()})
    worlds = list[str]()
    board.became_available.append(worlds.append)
    for battery in (0.9, 0.1, 0.1, 0.9, 0.9):
        board.heard("yard_1", said(battery))
    assert worlds == ["store"]


def test_why_a_robot_rests_is_told_whenever_that_is_new() -> None:
    board = RobotBoard([("yard_1", "store")], clocks={"store": ManualClock()})
    told = list[tuple[str, str, str]]()
    board.unavailability_changed.append(lambda *news: told.append(news))
    for battery, charging in (
        (0.9, False),
        (0.1, False),
        (0.102, False),
        (0.104, True),
        (0.11, True),
        (0.9, False),
    ):
        board.heard("yard_1", said(battery, charging=charging))
    assert told == [
        ("store", "yard_1", "which rests, its battery at 10%"),
        ("store", "yard_1", "which charges, its battery at 10%"),
        ("store", "yard_1", "which charges, its battery at 11%"),
    ]
