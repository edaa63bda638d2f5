"""A robot with software of its own, no more than an MQTT client: it announces itself, is admitted, and works."""

import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from paho.mqtt.client import Client, MQTTMessage, MQTTMessageInfo
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from app.planning.pool.pool import PlanningWorker
from robots.world import load_world
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.services import AUTHORISED, over_broker
from tests.scenarios.serving import macta_fleet
from tests.waiting import awaited, in_state, mission_of, until

pytestmark = needs_mosquitto
WORLD = "sample_store"
STORE = load_world(WORLD)


class PlainRobot:
    """Follows scripts packet by packet, each for as long as it is expected to take. It imports nothing of Macta."""

    def __init__(self, name: str, broker: Mosquitto, start: tuple[float, float, float]) -> None:
        self.name = name
        self.told: list[dict[str, Any]] = []
        """What it was told of its factsheet."""
        self.done: list[str] = []
        self._at = start[:2]
        self._start = start
        self._topic = f"macta/v1/{WORLD}/{name}"
        self._run = ""
        self._world_s = (0.0, 0.0, 1.0)
        """The world's time as last announced, when by the own clock, and its rate."""
        self._sent = 0
        self._seen: set[str] = set()
        self._scripts: list[dict[str, Any]] = []
        self._ends = threading.Event()
        self._client = Client(CallbackAPIVersion.VERSION2, name, protocol=MQTTProtocolVersion.MQTTv5)
        self._client.on_message = self._hear
        self._client.connect("127.0.0.1", broker.port)
        self._client.subscribe(
            [
                (f"macta/v1/{WORLD}/world", 1),
                (f"{self._topic}/order", 1),
                (f"{self._topic}/instantActions", 1),
            ]
        )
        self._client.loop_start()
        self._worker = threading.Thread(target=self._work)
        self._worker.start()

    def close(self) -> None:
        self._ends.set()
        self._worker.join()
        self._client.disconnect()
        self._client.loop_stop()

    def announce(self, number: int = 1, **values: Any) -> None:
        """Tell what it is, once it knows the world's run."""
        until(lambda: bool(self._run))
        sheet = {
            "kind": "factsheet",
            "number": number,
            "repertoire": ["NAVIGATE"],
            "speed_m_s": 0.4,
            "turn_rad_s": 1.0,
            "start": self._start,
        }
        self._say("factsheet", sheet | values, retain=True).wait_for_publish(10)

    def _now_s(self) -> float:
        world_s, at, rate = self._world_s
        return world_s + (time.monotonic() - at) * rate * 0.95  # rather late than in the future

    def _say(
        self,
        channel: str,
        body: dict[str, Any],
        *,
        performative: str = "inform",
        reply: str | None = None,
        retain: bool = False,
    ) -> MQTTMessageInfo:
        self._sent += 1
        message = {
            "id": f"{self.name}-{time.monotonic_ns()}-{self._sent}",
            "performative": performative,
            "sender": self.name,
            "receiver": "service",
            "sent_at_s": self._now_s(),
            "in_reply_to": reply,
            "body": body,
        }
        properties = Properties(PacketTypes.PUBLISH)  # type: ignore[no-untyped-call]
        properties.UserProperty = [("run", self._run)]
        return self._client.publish(f"{self._topic}/{channel}", json.dumps(message), 1, retain, properties)

    def _hear(self, client: Client, data: Any, arrived: MQTTMessage) -> None:
        said = json.loads(arrived.payload)
        if arrived.topic.endswith("/world"):
            self._run = said["run"]
            self._world_s = (said["time_s"], time.monotonic(), said["rate"])
            return
        body = said["body"]
        if body["kind"] == "factsheet_answer":
            self.told.append(body)
        elif body["kind"] == "script_request" and said["id"] not in self._seen:
            self._seen.add(said["id"])
            script = body["script"]
            acknowledged = {"kind": "acknowledgement", "script_id": script["id"]}
            self._say("state", acknowledged, performative="agree", reply=said["id"])
            self._scripts.append(script)

    def _work(self) -> None:
        while not self._ends.wait(0.1):
            if self._run:
                self._tell_where()
            if self._scripts:
                script = self._scripts.pop(0)
                for packet in script["packets"]:
                    self._do(script["id"], packet)
                self._report("script_report", script["id"], state="finished")

    def _do(self, script: str, packet: dict[str, Any]) -> None:
        self._report("packet_report", script, packet_id=packet["id"], state="running")
        until_s = self._now_s() + packet["expected_duration_s"]
        while self._now_s() < until_s and not self._ends.wait(0.1):
            self._tell_where()
        self._at = STORE.location(packet["arguments"]["ref2"]).at
        self._tell_where()
        self.done.append(packet["tag"])
        self._report("packet_report", script, packet_id=packet["id"], state="finished")

    def _report(self, kind: str, script: str, **values: Any) -> None:
        self._say("state", {"kind": kind, "script_id": script, "at_s": self._now_s(), **values})

    def _tell_where(self) -> None:
        pose = {"at_s": self._now_s(), "x_m": self._at[0], "y_m": self._at[1], "heading_rad": 0.0}
        self._client.publish(f"{self._topic}/visualization", json.dumps({"kind": "telemetry"} | pose))


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def visitor(broker: Mosquitto) -> Iterator[PlainRobot]:
    robot = PlainRobot("visitor_1", broker, (4.0, 1.4, -90.0))
    yield robot
    robot.close()


def robot(api: TestClient, name: str) -> dict[str, Any]:
    return api.get(f"/v1/robots/{name}").raise_for_status().json()  # type: ignore[no-any-return]


def test_a_robot_that_is_only_an_mqtt_client_is_admitted_and_carries_out_its_script(
    tmp_path: Path, worker: PlanningWorker, broker: Mosquitto, visitor: PlainRobot
) -> None:
    sheets = f"/v1/worlds/{WORLD}/factsheets"
    changes = f"/v1/worlds/{WORLD}/changes"
    with (
        macta_fleet(tmp_path / "fleet", "--broker", broker.url, "--speed", "10"),
        over_broker(tmp_path / "service", worker, broker.url) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
    ):
        visitor.announce()
        until(lambda: [one["state"] for one in visitor.told] == ["announced"])
        awaited(lambda: robot(api, "yard_1")["factsheet"] is not None, True.__eq__)  # simulated ones, too
        assert robot(api, "yard_1")["factsheet"]["state"] == "in_force"
        assert api.get("/v1/robots/visitor_1").status_code == 404

        api.post(f"/v1/worlds/{WORLD}/robots/visitor_1:admit").raise_for_status()
        until(lambda: visitor.told and visitor.told[-1]["state"] == "in_force")
        awaited(lambda: api.get(changes).json()["items"][0]["delivery"], "taken_up".__eq__)
        awaited(lambda: robot(api, "visitor_1")["connection"], "online".__eq__)
        assert robot(api, "visitor_1")["pose"]["x_m"] == 4.0  # nobody simulates it beside itself

        body = {"text": "send visitor_1 to door_2", "auto_approve": True}
        goal = api.post("/v1/goals", json=body).raise_for_status().json()
        mission = mission_of(api, goal["id"])
        assert in_state(api, f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
        assert visitor.done == ["NAVIGATE"]

        visitor.announce(number=2, speed_m_s=0.2)
        awaited(lambda: robot(api, "visitor_1")["factsheet"]["number"], (2).__eq__)
        newest = api.get(changes).json()["items"][0]
        assert (newest["actor"], newest["edits"][0]["speed_m_s"]) == ("visitor_1", 0.2)
        assert api.get(sheets).json()["items"][-1]["state"] == "in_force"


def test_a_factsheet_that_the_broker_keeps_is_read_by_a_service_that_starts_later(
    tmp_path: Path, worker: PlanningWorker, broker: Mosquitto, visitor: PlainRobot
) -> None:
    with macta_fleet(tmp_path / "fleet", "--broker", broker.url, "--speed", "10"):
        visitor.announce()
        with (
            over_broker(tmp_path / "service", worker, broker.url) as service,
            TestClient(service.api, headers=AUTHORISED) as api,
        ):
            sheets = f"/v1/worlds/{WORLD}/factsheets"
            names = {"visitor_1", *(one.name for one in STORE.robots)}
            awaited(lambda: {one["robot"] for one in api.get(sheets).json()["items"]}, names.__eq__)
