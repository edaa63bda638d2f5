"""A robot's mind moves from the fleet's simulation into the robot's own program, over a broker, and back."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
import yaml
from fastapi.testclient import TestClient

from app.domain.lifecycles.embodiment import OPEN
from app.planning.pool.pool import PlanningWorker
from robots.world import load_world
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.services import AUTHORISED, over_broker
from tests.scenarios.serving import macta_fleet
from tests.waiting import read_until, until

ROOT = Path(__file__).parents[2]
EMBODIMENT = "/v1/robots/carl/embodiment"


def world(folder: Path) -> Path:
    """The workshop of the example, whose robot is simulated."""
    document = json.loads(load_world(str(ROOT / "examples" / "own_robot.yaml")).model_dump_json())
    document["robots"][0]["external"] = False
    path = folder / "workshop.yaml"
    path.write_text(yaml.safe_dump(document))
    return path


@contextmanager
def own_program(broker: Mosquitto, file: Path, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Is killed at the end; another one goes on with its memory."""
    command = [sys.executable, "examples/own_robot.py", broker.url, file, "carl", folder / "carl.memory"]
    with (folder / "carl.log").open("ab") as log:
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        process = subprocess.Popen(command, cwd=ROOT, env=environment, stdout=log, stderr=log)
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def moved(api: httpx2.Client, kind: str) -> dict[str, Any]:
    """The newest move once it has ended, and the robot is in such a body."""
    known = read_until(api, EMBODIMENT, lambda one: one["attempts"][0]["state"] not in OPEN, within_s=60)
    assert known["kind"] == kind, known["attempts"][0]
    attempt: dict[str, Any] = known["attempts"][0]
    return attempt


def carried_out(api: httpx2.Client, text: str) -> None:
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).raise_for_status().json()["id"]
    ended = read_until(api, f"/v1/goals/{goal}", lambda one: one["outcome"] is not None, within_s=200)
    assert ended["outcome"] == "completed", ended


@needs_mosquitto
def test_a_robots_own_program_takes_its_mind_works_is_killed_goes_on_and_gives_the_mind_back(
    tmp_path: Path, worker: PlanningWorker
) -> None:
    file = world(tmp_path)
    with (
        mosquitto(tmp_path / "broker") as broker,
        macta_fleet(tmp_path / "fleet", "--speed", "2", "--world", str(file), "--broker", broker.url),
        over_broker(tmp_path / "service", worker, broker.url, world=str(file)) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
    ):
        read_until(api, "/v1/robots/carl", lambda one: one["connection"] == "online" and one["pose"])
        with own_program(broker, file, tmp_path):
            until(lambda: list(tmp_path.glob("carl.memory.*")))  # without a mind: its start may take long
            api.post("/v1/robots/carl:embody", json={"body": "real"}).raise_for_status()
            assert moved(api, "real")["state"] == "embodied"
            assert "embodiment.handing_over" in {one.type for one in service.events.since(0)}
            carried_out(api, "bring sample_1 to bay_2")
        read_until(api, "/v1/robots/carl", lambda one: one["connection"] != "online")
        with own_program(broker, file, tmp_path):
            read_until(api, "/v1/robots/carl", lambda one: one["connection"] == "online")
            api.post("/v1/robots/carl:embody", json={"body": "wheeled"}).raise_for_status()
            assert moved(api, "simulated")["state"] == "embodied"
            carried_out(api, "send carl to bay_1")
    facts = {line for line in (tmp_path / "carl.log").read_text().splitlines() if "Error" in line}
    assert facts == set()
