"""A robot of somebody else's: an MQTT client that senses nothing and drives by time. It imports nothing of Macta."""

import json
import threading
import time
from collections.abc import Mapping
from math import atan2, cos, dist, radians, sin
from typing import Any

from paho.mqtt.client import Client, MQTTMessage, MQTTMessageInfo
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

STAND_OFF_M = 0.9
REPEATED_S = 0.5
TICK_S = 0.05
TAGS = ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]


class ForeignRobot:
    """Carries scripts out packet by packet, each for as long as it is expected to take, and repeats its reports."""

    def __init__(self, name: str, port: int, world: Mapping[str, Any]) -> None:
        """:param world: the document of the world file, which has the robot."""
        self.name = name
        self.done: list[tuple[str, str]] = []
        """Tag and object, or destination, of each packet that it has finished."""
        self.holding: str | None = None
        self.told: list[dict[str, Any]] = []
        """What it was told of its factsheet."""
        spec = next(one for one in world["robots"] if one["name"] == name)
        area = next(one for one in world["compartments"] if one["name"] == spec["compartment"])
        self._area = (area["x"], area["y"])
        self._places = {one["name"]: one for one in world["locations"]}
        self._at: tuple[float, float] = tuple(spec["start"][:2])
        self._heading_rad = radians(spec["start"][2])
        self._topic = f"macta/v1/{world['name']}/{name}"
        self._run = ""
        self._clock = (0.0, 0.0, 1.0)
        self._sent = 0
        self._cleared: set[str] = set()
        self._known: set[str] = set()
        self._scripts: list[dict[str, Any]] = []
        self._unconfirmed: dict[str, tuple[float, bytes]] = {}
        self._ends = threading.Event()
        self._client = Client(CallbackAPIVersion.VERSION2, name, protocol=MQTTProtocolVersion.MQTTv5)
        self._client.on_message = self._hear
        self._client.connect("127.0.0.1", port)
        topics = (f"macta/v1/{world['name']}/world", f"{self._topic}/order", f"{self._topic}/instantActions")
        self._client.subscribe([(topic, 1) for topic in topics])
        self._client.loop_start()
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def close(self) -> None:
        if self._ends.is_set():
            return
        self._ends.set()
        self._thread.join()
        self._publish("connection", b'{"state": "offline"}', retain=True).wait_for_publish(10)
        self._client.disconnect()
        self._client.loop_stop()

    def _work(self) -> None:
        while not self._run and not self._ends.wait(TICK_S):
            pass
        sheet = {"number": 1, "repertoire": TAGS, "speed_m_s": 0.5, "turn_rad_s": 1.5, "senses": []}
        self._say("factsheet", {"kind": "factsheet", **sheet}, retain=True)
        self._publish("connection", b'{"state": "online"}', retain=True)
        while not self._ends.wait(TICK_S):
            self._tick()
            if self._scripts:
                self._carry_out(self._scripts.pop(0))

    def _carry_out(self, script: dict[str, Any]) -> None:
        for packet in script["packets"]:
            while not self._cleared.issuperset(packet["after"]) and not self._ends.wait(TICK_S):
                self._tick()
            assert not packet["awaits"], "it senses nothing"
            self._report("packet_report", script["id"], packet_id=packet["id"], state="running")
            self._do(packet)
            self._report("packet_report", script["id"], packet_id=packet["id"], state="finished")
        self._report("script_report", script["id"], state="finished")

    def _do(self, packet: dict[str, Any]) -> None:
        """Drive there evenly, or stand and grip or release at the end of the time."""
        arguments = packet["arguments"]
        drives = packet["tag"] in ("NAVIGATE", "TRANSPORT")
        start, began_s = self._at, self._now_s()
        goal = self._before(arguments["ref2"]) if drives else start
        if dist(start, goal) > 0:
            self._heading_rad = atan2(goal[1] - start[1], goal[0] - start[0])
        takes_s = packet["expected_duration_s"]
        while (share := (self._now_s() - began_s) / takes_s) < 1 and not self._ends.wait(TICK_S):
            self._at = (start[0] + share * (goal[0] - start[0]), start[1] + share * (goal[1] - start[1]))
            self._tick()
        self._at = goal
        if packet["tag"] == "DOCK":
            self.holding = arguments["object"]
        elif packet["tag"] == "RELEASE2":
            self.holding = None
        self.done.append((packet["tag"], arguments["ref2"] if drives else arguments["object"]))
        self._tick()

    def _before(self, place: str) -> tuple[float, float]:
        """Where it stands to grip at a place, on its own side."""
        location = self._places[place]
        (x, y), (across, along) = location["at"], self._area
        points = [
            (x + STAND_OFF_M * cos(radians(angle)), y + STAND_OFF_M * sin(radians(angle)))
            for angle in location["approach_deg"]
        ]
        return next(
            one for one in points if across[0] <= one[0] <= across[1] and along[0] <= one[1] <= along[1]
        )

    def _tick(self) -> None:
        """Tell where it is, and repeat what was not confirmed."""
        pose = {
            "at_s": self._now_s(),
            "x_m": self._at[0],
            "y_m": self._at[1],
            "heading_rad": self._heading_rad,
        }
        said = {"kind": "telemetry", "holding": self.holding, **pose}
        self._client.publish(f"{self._topic}/visualization", json.dumps(said))
        for message_id, (said_s, payload) in list(self._unconfirmed.items()):
            if time.monotonic() - said_s > REPEATED_S:
                self._unconfirmed[message_id] = time.monotonic(), payload
                self._publish("state", payload)

    def _now_s(self) -> float:
        world_s, at_s, rate = self._clock
        return world_s + 0.95 * rate * (time.monotonic() - at_s)  # rather late than in the future

    def _report(self, kind: str, script: str, **values: Any) -> None:
        body = {"kind": kind, "script_id": script, "at_s": self._now_s(), **values}
        message_id, payload = self._say("state", body)
        self._unconfirmed[message_id] = time.monotonic(), payload

    def _say(
        self,
        channel: str,
        body: dict[str, Any],
        performative: str = "inform",
        reply: str | None = None,
        retain: bool = False,
    ) -> tuple[str, bytes]:
        self._sent += 1
        message = {
            "id": str(self._sent),
            "performative": performative,
            "sender": self.name,
            "receiver": "service",
            "sent_at_s": self._now_s(),
            "in_reply_to": reply,
            "body": body,
        }
        payload = json.dumps(message).encode()
        self._publish(channel, payload, retain=retain)
        return message["id"], payload

    def _publish(self, channel: str, payload: bytes, *, retain: bool = False) -> MQTTMessageInfo:
        properties = Properties(PacketTypes.PUBLISH)  # type: ignore[no-untyped-call]
        properties.UserProperty = [("run", self._run)]
        return self._client.publish(f"{self._topic}/{channel}", payload, 1, retain, properties)

    def _hear(self, _: Client, __: Any, arrived: MQTTMessage) -> None:
        said = json.loads(arrived.payload)
        if arrived.topic.endswith("/world"):
            self._run = said["run"]
            self._clock = (said["time_s"], time.monotonic(), said["rate"])
            return
        body = said["body"]
        if body["kind"] == "receipt":
            self._unconfirmed.pop(said["in_reply_to"], None)
        elif body["kind"] == "factsheet_answer":
            self.told.append(body)
        elif body["kind"] == "script_request":
            self._agree(said, body["script"]["id"])
            if body["script"]["id"] not in self._known:
                self._known.add(body["script"]["id"])
                self._scripts.append(body["script"])
        elif body["kind"] == "clearance":
            self._agree(said, body["script_id"])
            self._cleared.update(body["ended"])

    def _agree(self, asked: dict[str, Any], script: str) -> None:
        acknowledgement = {"kind": "acknowledgement", "script_id": script}
        self._say("state", acknowledgement, performative="agree", reply=asked["id"])
