"""Simulated, virtual and foreign robots, and vehicles of VDA 5050, in one world hand samples over to each other."""

import json
from collections.abc import Iterator
from contextlib import ExitStack, closing
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
from tests.scenarios.virtual_vehicle import VirtualVehicle, adapter, needs_node
from tests.waiting import ENDED, in_state, mission_of, read_until, until

pytestmark = needs_mosquitto
FOREIGN = ("yard_1", "yard_2")


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def world(tmp_path: Path) -> dict[str, Any]:
    """The sample store, whose yard robots are somebody else's."""
    return stored(tmp_path, {name: {"external": True} for name in FOREIGN})


def stored(folder: Path, changed: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The sample store as `mixed_store.yaml`; some robots are otherwise."""
    document = json.loads(load_world("sample_store").model_dump_json(exclude_defaults=True))
    for robot in document["robots"]:
        robot.update(changed.get(robot["name"], {}))
    document["name"] = "mixed_store"
    (folder / "mixed_store.yaml").write_text(yaml.safe_dump(document))
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


@needs_node
def test_a_simulated_a_virtual_a_foreign_robot_and_a_vda_5050_vehicle_work_side_by_side(
    tmp_path: Path, worker: PlanningWorker, broker: Mosquitto
) -> None:
    """The vehicle hands a sample to the simulated robot, and that to the foreign one, while the avatar drives."""
    kinds = {"yard_2": {"body": "avatar"}, "store_1": {"external": True}, "store_2": {"external": True}}
    world = stored(tmp_path, kinds)
    file = tmp_path / "mixed_store.yaml"
    with (
        macta_fleet(tmp_path / "fleet", "--broker", broker.url, "--speed", "8", "--world", str(file)),
        over_broker(tmp_path / "service", worker, broker.url, world=str(file)) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
        closing(VirtualVehicle(broker, x_m=6, y_m=7.7, speed_m_s=2)),
        adapter(tmp_path / "memory", file, broker, robot="store_2"),
        closing(ForeignRobot("store_1", broker.port, world)) as foreign,
    ):
        for robot in world["robots"]:
            read_until(
                api, f"/v1/robots/{robot['name']}", lambda one: one["connection"] == "online" and one["pose"]
            )
        at_home = api.get("/v1/robots/yard_2").json()["pose"]
        mission, drive = begun(api, "move sample_4 to bay_1"), begun(api, "send yard_2 to door_2")
        carried, driven = completed(api, mission), completed(api, drive)

        packets = {one["robot"]: [packet["tag"] for packet in one["packets"]] for one in carried["progress"]}
        assert packets.keys() == {"store_2", "yard_1", "store_1"}
        assert all("DOCK" in tags and "RELEASE2" in tags for tags in packets.values()), packets
        assert [one["robot"] for one in driven["progress"]] == ["yard_2"]
        assert foreign.done[-1] == ("RELEASE2", "sample_4")
        believed = {
            (one["predicate"], *one["args"])
            for one in api.get("/v1/worlds/mixed_store/facts").json()["items"]
        }
        assert ("in", "sample_4", "bay_1") in believed
        moved = api.get("/v1/robots/yard_2").json()["pose"]
        assert abs(moved["y_m"] - at_home["y_m"]) > 0.2


def carried_out(api: TestClient, text: str) -> None:
    """A goal is reached by a mission."""
    completed(api, begun(api, text))


def begun(api: TestClient, text: str) -> str:
    """The mission of a goal."""
    body = {"text": text, "auto_approve": True, "recovery": "never"}
    goal = api.post("/v1/goals", json=body).raise_for_status().json()
    return mission_of(api, goal["id"])


def completed(api: TestClient, mission: str) -> dict[str, Any]:
    """The mission, once it has reached its goal."""
    ended = in_state(api, f"/v1/missions/{mission}", *ENDED, within_s=120)
    assert ended["state"] == "completed", ended["reason"]
    return ended
