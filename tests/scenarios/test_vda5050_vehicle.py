"""The virtual vehicle of the package vda-5050-lib as a robot: recruited, driven, cut off, found again.

It is a process of its own and speaks VDA 5050 2.0 by MQTT; nothing of it is changed.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.planning.pool.pool import PlanningWorker
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.services import AUTHORISED, over_broker
from tests.scenarios.virtual_vehicle import VirtualVehicle, adapter, needs_node
from tests.waiting import awaited, in_state, mission_of, until

pytestmark = [needs_mosquitto, needs_node]
SPEED_M_S = 2.0
HALL = """
name: hall
compartments:
  - {name: hall, x: [0, 5], y: [0, 6]}
walls:
  - {start: [0, 0], end: [5, 0]}
  - {start: [5, 0], end: [5, 6]}
  - {start: [5, 6], end: [0, 6]}
  - {start: [0, 6], end: [0, 0]}
locations:
  - {name: bay_1, kind: bay, at: [0.5, 2], approach_deg: [0]}
  - {name: bay_2, kind: bay, at: [4.5, 2], approach_deg: [180]}
  - {name: home_1, kind: home, at: [2.5, 0.6], approach_deg: [90], capacity: 0}
robots:  # a world has one at least; nobody speaks for this one
  - {name: absent_1, compartment: hall, start: [1, 5, 0], home: home_1, external: true, repertoire: [TRACK]}
samples:
  - {name: sample_1, at: bay_1}
"""


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def vehicle(broker: Mosquitto) -> Iterator[VirtualVehicle]:
    vehicle = VirtualVehicle(broker, speed_m_s=SPEED_M_S)
    yield vehicle
    vehicle.close()


def stated(api: TestClient, text: str) -> str:
    """The mission of a goal that is approved at once."""
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).raise_for_status().json()
    return mission_of(api, goal["id"])


def completed(api: TestClient, mission: str) -> dict[str, Any]:
    ended = in_state(api, f"/v1/missions/{mission}", "completed", "failed")
    assert ended["state"] == "completed", ended
    return ended


@pytest.fixture
def api(
    tmp_path: Path, worker: PlanningWorker, broker: Mosquitto, vehicle: VirtualVehicle
) -> Iterator[TestClient]:
    """A service in whose world the vehicle has been found and admitted."""
    world = tmp_path / "hall.yaml"
    world.write_text(HALL)
    with (
        over_broker(tmp_path / "service", worker, broker.url, world=str(world)) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
        adapter(tmp_path / "memory", world, broker) as control,
    ):
        until(lambda: "agv_7" in control.robots)
        sheets = "/v1/worlds/hall/factsheets"
        awaited(lambda: [one["state"] for one in api.get(sheets).json()["items"]], ["announced"].__eq__)
        sheet = api.get(sheets).json()["items"][0]["sheet"]
        assert set(sheet["repertoire"]) == {"NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"}
        assert (sheet["speed_m_s"], sheet["senses"]) == (SPEED_M_S, [])
        api.post("/v1/worlds/hall/robots/agv_7:admit").raise_for_status()
        awaited(lambda: seen(api)["connection"], "online".__eq__)
        yield api


def seen(api: TestClient) -> dict[str, Any]:
    return api.get("/v1/robots/agv_7").raise_for_status().json()  # type: ignore[no-any-return]


def stands_at(api: TestClient, x_m: float) -> None:
    awaited(lambda: seen(api)["pose"]["x_m"], pytest.approx(x_m, abs=0.2).__eq__)


def test_a_published_virtual_vehicle_is_recruited_and_driven(api: TestClient) -> None:
    completed(api, stated(api, "send agv_7 to bay_2"))
    stands_at(api, 3.7)

    mission = completed(api, stated(api, "move sample_1 to bay_2"))
    tags = [packet["tag"] for packet in mission["progress"][0]["packets"]]
    assert tags == ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]


def test_one_that_is_cut_off_while_it_drives_is_found_again(api: TestClient, vehicle: VirtualVehicle) -> None:
    completed(api, stated(api, "send agv_7 to bay_2"))
    stands_at(api, 3.7)

    mission = stated(api, "send agv_7 to bay_1")
    awaited(lambda: seen(api)["pose"]["x_m"], lambda x: x < 3.2)
    vehicle.cut_off(True)
    awaited(lambda: seen(api)["connection"], "connection_broken".__eq__)
    vehicle.cut_off(False)
    awaited(lambda: seen(api)["connection"], "online".__eq__)
    completed(api, mission)
    stands_at(api, 1.3)
