"""Simulated and foreign robots in one world hand samples over to each other."""

import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
import yaml
from fastapi.testclient import TestClient

from app.planning.pool.pool import PlanningWorker
from robots.world import load_world
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.foreign_robot import ForeignRobot
from tests.scenarios.services import AUTHORISED, over_broker
from tests.scenarios.serving import macta_fleet
from tests.waiting import ENDED, in_state, read_until, until

pytestmark = needs_mosquitto
FOREIGN = ("yard_1", "yard_2")


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def world(tmp_path: Path) -> dict[str, Any]:
    """The sample store, whose yard robots are somebody else's."""
    document = json.loads(load_world("sample_store").model_dump_json(exclude_defaults=True))
    for robot in document["robots"]:
        robot["external"] = robot["name"] in FOREIGN
    document["name"] = "mixed_store"
    (tmp_path / "mixed_store.yaml").write_text(yaml.safe_dump(document))
    return document  # type: ignore[no-any-return]


def test_two_simulated_and_two_foreign_robots_bring_a_sample_to_its_bay(
    tmp_path: Path, worker: PlanningWorker, broker: Mosquitto, world: dict[str, Any]
) -> None:
    file = str(tmp_path / "mixed_store.yaml")
    with (
        macta_fleet(tmp_path / "fleet", "--broker", broker.url, "--speed", "8", "--world", file),
        over_broker(tmp_path / "service", worker, broker.url, world=file) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
        ExitStack() as robots,
    ):
        foreign = [ForeignRobot(name, broker.port, world) for name in FOREIGN]
        for robot in foreign:
            robots.callback(robot.close)
        for name in FOREIGN:
            read_until(api, f"/v1/robots/{name}", lambda one: one["factsheet"] and one["pose"])
        carried_out(api, "move sample_3 to bay_7")
        believed = {
            (one["predicate"], *one["args"])
            for one in api.get("/v1/worlds/mixed_store/facts").json()["items"]
        }
        assert ("in", "sample_3", "bay_7") in believed
        carried = [
            (tag, thing) for robot in foreign for tag, thing in robot.done if tag in ("DOCK", "RELEASE2")
        ]
        assert carried == [("DOCK", "sample_3"), ("RELEASE2", "sample_3")]

        # One of the foreign robots is switched off, and its twin simulated in its place.
        (mover,) = [robot for robot in foreign if robot.holding is None and robot.done]
        mover.close()
        stood = api.get(f"/v1/robots/{mover.name}").json()["pose"]
        edit = {"edit": "change_robot", "name": mover.name, "external": False}
        change = {"edits": [edit], "reason": "its motor is repaired"}
        read_until(api, f"/v1/robots/{mover.name}", lambda one: one["connection"] == "offline")
        api.post("/v1/worlds/mixed_store/changes", json=change).raise_for_status()
        twin = read_until(
            api, f"/v1/robots/{mover.name}", lambda one: one["factsheet"] and one["connection"] == "online"
        )
        assert abs(twin["pose"]["x_m"] - stood["x_m"]) < 0.3
        assert abs(twin["pose"]["y_m"] - stood["y_m"]) < 0.3
        carried_out(api, f"send {mover.name} to door_2")
        again = ForeignRobot(mover.name, broker.port, world)
        robots.callback(again.close)
        until(lambda: [one["state"] for one in again.told] == ["refused"])
        assert "is simulated now" in again.told[0]["reason"]


def carried_out(api: TestClient, text: str) -> None:
    """A goal is reached by a mission."""
    body = {"text": text, "auto_approve": True, "recovery": "never"}
    goal = api.post("/v1/goals", json=body).raise_for_status().json()
    mission = in_state(api, f"/v1/goals/{goal['id']}", "committed", "completed")["mission_id"]
    ended = in_state(api, f"/v1/missions/{mission}", *ENDED, within_s=120)
    assert ended["state"] == "completed", ended
