"""A simulated robot of Macta under the master control of the package vda-5050-lib, over a broker.

The master control is a process of its own and speaks VDA 5050 2.0; nothing of it is changed.
"""

import shutil
from contextlib import closing
from pathlib import Path

import pytest

from robots.adapters.vda5050.topics import Topic, VehicleId
from robots.world import shipped_worlds
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.robots.adapters.vda5050.published_schemas import faults
from tests.scenarios.foreign_vda5050 import FOLDER, ForeignMaster, action, as_vehicle, recorded
from tests.scenarios.serving import macta_fleet

pytestmark = [
    needs_mosquitto,
    pytest.mark.skipif(
        shutil.which("node") is None or not (FOLDER / "node_modules").is_dir(),
        reason=f"no node, or not installed: npm install --prefix {FOLDER.relative_to(Path.cwd())}",
    ),
]
VEHICLE = VehicleId(manufacturer="macta", serial_number="yard_1", major=2)


START = {"nodeId": "start", "nodePosition": {"x": 1.4, "y": 1.8, "mapId": "default"}}
PICK = action("pick", "pick-1", loadId="sample_1")
DROP = action("drop", "drop-1", loadId="sample_1")


def test_a_foreign_master_drives_a_robot_of_ours(tmp_path: Path) -> None:
    world = shipped_worlds()["sample_store"]
    with (
        mosquitto(tmp_path / "broker") as broker,
        macta_fleet(tmp_path / "fleet", "--broker", broker.url, "--speed", "2"),  # two drives are interrupted
        recorded(broker, VEHICLE) as heard,
        closing(ForeignMaster(broker, VEHICLE)) as master,
    ):
        with as_vehicle("yard_1", broker, tmp_path, world) as adapter:
            master.connection("ONLINE")
            master.does("factsheetRequest")
            sheet = master.awaits(lambda one: one["event"] == "factsheet")["sheet"]
            assert {"pick", "drop", "cancelOrder"} <= {
                one["actionType"] for one in sheet["protocolFeatures"]["agvActions"]
            }

            master.order(
                "carry",
                [
                    START,
                    {"nodeId": "door_1", "actions": [PICK]},
                    {"nodeId": "interchange_1", "released": False},
                ],
            )
            master.is_done("carry", isActive=True)
            master.state(loads=["sample_1"], lastNodeId="door_1")
            master.order("other", [{"nodeId": "door_1"}, {"nodeId": "door_2"}])
            master.is_done("other", error="orderError")
            master.order(
                "carry",
                [{"nodeId": "door_1"}, {"nodeId": "interchange_1", "actions": [DROP]}],
                update=1,
                first=2,
            )
            master.state(driving=True)
            master.does("startPause")
            master.state(paused=True, driving=False)
            master.does("stopPause")
            master.state(paused=False, driving=True)

            adapter.kill()  # the broker publishes its last will
            adapter.wait()
            master.connection("CONNECTIONBROKEN")
        with as_vehicle("yard_1", broker, tmp_path, world):
            master.connection("ONLINE")
            master.is_done("carry", update=1)
            master.state(loads=[], lastNodeId="interchange_1")
            assert [one["id"] for one in master.events if one.get("status") == "RUNNING"].count("pick-1") == 1

            master.order("nowhere", [{"nodeId": "interchange_1"}, {"nodeId": "bay_99"}])
            master.is_done("nowhere", error="noRouteError")
            master.order("away", [{"nodeId": "interchange_1"}, {"nodeId": "door_2"}])
            master.state(orderId="away", driving=True)
            master.events.clear()
            broker.kill()
            broker.start()
            master.connection("ONLINE")
            master.does("cancelOrder")
            master.is_done("away", isCancelled=True)
            master.instant("cancelOrder")
            master.state(driving=False, errors=["noOrderToCancel"])
        master.connection("OFFLINE")
        assert master.dropped == []  # what is invalid by its schemas of 2.0
    told = {topic for topic, _ in heard}
    assert told == set(Topic)
    ours = [(topic, payload) for topic, payload in heard if not topic.is_for_vehicles]
    assert [fault for topic, payload in ours for fault in faults(2, topic, payload)] == []
