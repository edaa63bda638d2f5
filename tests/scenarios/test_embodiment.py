"""A robot's mind moves between a simulated and a virtual body in the middle of a mission, and processes are killed."""

import os
import signal
from pathlib import Path
from typing import Any

import httpx2

from app.domain.lifecycles.embodiment import OPEN
from tests.scenarios.killing import kill_family, process_of_the_world
from tests.scenarios.serving import macta_serve
from tests.waiting import in_state, read_until

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
        mission = f"/v1/missions/{in_state(api, f'/v1/goals/{goal}', 'committed')['mission_id']}"
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
