"""A robot's mind moves between a simulated and a virtual body in the middle of a mission, and processes are killed."""

import os
import signal
from pathlib import Path
from typing import Any

import httpx2
from fastapi.testclient import TestClient

from app.domain.lifecycles.embodiment import OPEN
from app.planning.pool.pool import PlanningWorker
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.scenarios.killing import kill_family, process_of_the_world
from tests.scenarios.services import AUTHORISED, over_broker
from tests.scenarios.serving import macta_fleet, macta_serve
from tests.waiting import in_state, mission_of, read_until

SPEED = ("--speed", "8")


def path(robot: str) -> str:
    return f"/v1/robots/{robot}/embodiment"


def moved(api: httpx2.Client, robot: str, body: str) -> dict[str, Any]:
    """The newest move once it has ended, and the robot is in that body."""
    known = read_until(api, path(robot), lambda one: one["attempts"][0]["state"] not in OPEN)
    assert known["body"]["kind"] == body, known
    attempt: dict[str, Any] = known["attempts"][0]
    return attempt


def test_minds_move_during_a_mission_though_service_and_world_are_killed(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with macta_serve(data, *SPEED) as first, first.client() as api:
        goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()[
            "id"
        ]
        mission = f"/v1/missions/{mission_of(api, goal)}"
        in_state(api, mission, "running")
        robots = [one["name"] for one in api.get("/v1/robots").json()["items"] if one["mission_id"]]
        for robot in robots:
            api.post(f"/v1/robots/{robot}:embody", json={"body": "avatar"}).raise_for_status()
        kill_family(first.process.pid)
        first.process.wait()

    with macta_serve(data, *SPEED) as second, second.client() as api:
        for robot in robots:
            assert moved(api, robot, "avatar")["state"] == "embodied"
            assert api.get(f"/v1/robots/{robot}").json()["body"] == "virtual"
        api.post(f"/v1/robots/{robots[0]}:embody", json={"body": "wheeled"}).raise_for_status()
        os.kill(process_of_the_world(second.process.pid, data), signal.SIGKILL)  # the service itself lives on
        assert moved(api, robots[0], "wheeled")["fence"] == 2
        ended = in_state(api, mission, "completed", "failed")
        assert ended["state"] == "completed", ended
        done = [one for robot in ended["progress"] for one in robot["packets"]]
        assert {one["state"] for one in done} == {"finished"}


@needs_mosquitto
def test_a_mind_moves_over_the_broker_though_the_fleet_that_has_both_bodies_is_killed(
    tmp_path: Path, worker: PlanningWorker
) -> None:
    fleet = (tmp_path / "fleet", "--world", "sample_store")
    with (
        mosquitto(tmp_path / "broker") as broker,
        over_broker(tmp_path / "service", worker, broker.url) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
    ):
        with macta_fleet(*fleet, "--broker", broker.url, "--speed", "1") as first:  # under way for 10 s
            goal = api.post("/v1/goals", json={"text": "send yard_1 to door_2", "auto_approve": True}).json()[
                "id"
            ]
            mission = f"/v1/missions/{mission_of(api, goal)}"
            in_state(api, mission, "running")
            api.post("/v1/robots/yard_1:embody", json={"body": "avatar"}).raise_for_status()
            kill_family(first.pid)
            first.wait()
        with macta_fleet(*fleet, "--broker", broker.url, "--speed", "8"):
            assert moved(api, "yard_1", "avatar")["state"] == "embodied"
            ended = in_state(api, mission, "completed", "failed")
            assert ended["state"] == "completed", ended
