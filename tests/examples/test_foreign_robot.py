"""A stranger's robots, sixty lines on an MQTT client, do the main job for a real service."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from robots.world import WorldFile, load_world
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.serving import macta_serve
from tests.waiting import awaited, in_state, mission_of

EXAMPLE = Path(__file__).parents[2] / "examples" / "foreign_robot.py"
STORE = load_world("sample_store")
FAST = {"speed_m_s": 2.0, "turn_rad_s": 6.0}
PLACES = {place.name: place.at for place in STORE.locations}


def world_of_strangers(folder: Path) -> Path:
    """The sample store's file, in which all robots are other people's."""
    robots = [one.model_dump(mode="json", exclude_defaults=True) for one in STORE.robots]
    world = STORE.model_dump(mode="json", exclude_defaults=True)
    world |= {"name": "annexe", "robots": [one | FAST | {"external": True} for one in robots]}
    path = folder / "annexe.yaml"
    path.write_text(yaml.safe_dump(world))
    return path


def sheet(robot: Any) -> dict[str, Any]:
    """What it knows of itself; it sees nothing that others do."""
    said = {"repertoire": robot.repertoire, "senses": [], "start": robot.start, "firmware": "4.2", **FAST}
    return {"number": 1, "compartment": robot.compartment, "aisle": robot.aisle, "home": robot.home} | said


@contextmanager
def strangers(broker: Mosquitto, world: WorldFile = STORE) -> Iterator[None]:
    """The example, once for each robot."""
    processes = [
        subprocess.Popen(
            [
                sys.executable,
                str(EXAMPLE),
                "127.0.0.1",
                str(broker.port),
                "annexe",
                one.name,
                json.dumps(sheet(one)),
                json.dumps(PLACES),
            ]
        )
        for one in world.robots
    ]
    try:
        yield
        assert [process.poll() for process in processes] == [None] * len(processes)
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_it_is_short_and_imports_nothing_of_ours() -> None:
    lines = [line for line in EXAMPLE.read_text().splitlines() if line.strip()]
    assert len(lines) <= 60
    assert max(map(len, lines)) <= 120
    assert not re.search(r"import .*\b(app|robots|planner|sim|web)\b|sha|digest", "\n".join(lines))


@needs_mosquitto
def test_robots_of_sixty_lines_do_the_main_job_without_a_fleet(tmp_path: Path) -> None:
    with (
        mosquitto(tmp_path / "broker") as broker,
        strangers(broker),
        macta_serve(
            tmp_path / "data", "--broker", broker.url, "--world", str(world_of_strangers(tmp_path))
        ) as served,
        served.client() as api,
    ):
        awaited(
            lambda: {one["connection"] for one in api.get("/v1/robots").json()["items"]}, {"online"}.__eq__
        )
        awaited(
            lambda: [one["state"] for one in api.get("/v1/worlds/annexe/factsheets").json()["items"]],
            (["in_force"] * len(STORE.robots)).__eq__,
        )
        ready = api.get("/readyz").json()
        assert ready["status"] == "ready"
        assert "invalid_messages" not in ready
        body = {"text": "move sample_1 to bay_7", "auto_approve": True}
        goal = api.post("/v1/goals", json=body).raise_for_status().json()
        mission = mission_of(api, goal["id"])
        ended = in_state(api, f"/v1/missions/{mission}", "completed", "failed", "cancelled")
        assert ended["state"] == "completed"
        facts = api.get("/v1/worlds/annexe/facts").json()["items"]
        assert [f["args"][1] for f in facts if f["predicate"] == "in" and f["args"][0] == "sample_1"] == [
            "bay_7"
        ]
