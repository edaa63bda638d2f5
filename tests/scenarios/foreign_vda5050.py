"""The master control of the package vda-5050-lib as a process, and the adapter between it and Macta's robots."""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from paho.mqtt.client import Client, MQTTMessage
from paho.mqtt.enums import CallbackAPIVersion

from robots.adapters.vda5050.topics import Topic, VehicleId
from tests.mosquitto import Mosquitto
from tests.waiting import awaited

FOLDER = Path(__file__).parent.parent / "third_party" / "vda5050"
INTERFACE = "uagv"
Json = dict[str, Any]


class ForeignMaster:
    """The process. `events`: what it was told of, as it said it, in order, since they were last cleared."""

    def __init__(self, broker: Mosquitto, vehicle: VehicleId) -> None:
        self.events: list[Json] = []
        self.dropped: list[str] = []
        """What it did not accept as a message of VDA 5050 2.0."""
        self._actions = 0
        self._process = subprocess.Popen(
            ["node", str(FOLDER / "master.js"), broker.url, vehicle.manufacturer, vehicle.serial_number],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._reads = threading.Thread(target=self._read, daemon=True)
        self._reads.start()
        self.awaits(lambda one: one["event"] == "ready")

    def order(self, order_id: str, nodes: Sequence[Json], *, update: int = 0, first: int = 0) -> None:
        """Assign an order of nodes in a row, and edges between them.

        :param first: the first node's sequence number.
        """
        numbered = [
            {"sequenceId": first + 2 * i, "released": True, "actions": [], **one}
            for i, one in enumerate(nodes)
        ]
        edges = [
            {
                "edgeId": f"{one['nodeId']}-{two['nodeId']}",
                "sequenceId": one["sequenceId"] + 1,
                "startNodeId": one["nodeId"],
                "endNodeId": two["nodeId"],
                "released": two["released"],
                "actions": [],
            }
            for one, two in pairwise(numbered)
        ]
        self._say(
            {"order": {"orderId": order_id, "orderUpdateId": update, "nodes": numbered, "edges": edges}}
        )

    def instant(self, kind: str, **parameters: str) -> str:
        """Have an instant action done; its id."""
        self._actions += 1
        action_id = f"{kind}-{self._actions}"
        self._say({"instant": [action(kind, action_id, blocking="NONE", **parameters)]})
        return action_id

    def does(self, kind: str, **parameters: str) -> None:
        """Have an instant action done, and wait until it has ended well."""
        action_id = self.instant(kind, **parameters)
        self.awaits(lambda one: one["event"] == "instant" and one["id"] == action_id, _finished)

    def awaits(
        self, is_meant: Callable[[Json], object], holds: Callable[[Json], object] = lambda one: True
    ) -> Json:
        """The newest event of a kind, once it is as it should be."""

        def newest() -> Json:
            return next((one for one in reversed(self.events.copy()) if is_meant(one)), {})

        return awaited(newest, lambda one: one and holds(one))

    def state(self, **values: object) -> Json:
        """The vehicle's state, once it has these values."""
        return self.awaits(lambda one: one["event"] == "state", lambda one: values.items() <= one.items())

    def connection(self, state: str) -> None:
        """Wait for the vehicle's connection to be in a state."""
        self.awaits(lambda one: one["event"] == "connection", lambda one: one["state"] == state)

    def is_done(self, order_id: str, **values: object) -> None:
        """Wait for an order's end."""
        wanted = {"isCancelled": False, "isActive": False, "error": None, **values}
        self.awaits(
            lambda one: one["event"] == "order" and one["id"] == order_id,
            lambda one: wanted.items() <= one.items(),
        )

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()

    def _say(self, command: Json) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(command) + "\n")
        self._process.stdin.flush()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            event = json.loads(line)
            self.events.append(event)
            if event["event"] in ("dropped", "refused"):
                self.dropped.append(event["why"])


def _finished(event: Json) -> bool:
    return bool(event["status"] == "FINISHED")


def action(kind: str, action_id: str, *, blocking: str = "HARD", **parameters: str) -> Json:
    given = [{"key": key, "value": value} for key, value in parameters.items()]
    return {
        "actionType": kind,
        "actionId": action_id,
        "blockingType": blocking,
        "actionParameters": given,
    }


@contextmanager
def as_vehicle(
    robot: str, broker: Mosquitto, folder: Path, world_file: Path
) -> Iterator[subprocess.Popen[bytes]]:
    """The adapter's command, as an operator starts it."""
    settings = folder / "settings.yaml"
    settings.write_text("states: 2.0.0\n")
    with (folder / "adapter.log").open("ab") as log:
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", "robots.adapters.vda5050"),
                *("--broker", broker.url, "--world", world_file.stem, "--world-file", str(world_file)),
                *("--settings", str(settings), "--memory", str(folder / "memory"), "--vehicle", robot),
            ],
            stdout=log,
            stderr=log,
        )
        try:
            yield process
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
                assert process.wait(timeout=60) == 0
        finally:
            process.kill()
            process.wait()


@contextmanager
def recorded(broker: Mosquitto, vehicle: VehicleId) -> Iterator[list[tuple[Topic, bytes]]]:
    """All that is published on a vehicle's topics during the block."""
    heard: list[tuple[Topic, bytes]] = []

    def take(_client: Client, _data: object, message: MQTTMessage) -> None:
        found = VehicleId.of_topic(message.topic)
        if found is not None and message.payload:
            heard.append((found[1], message.payload))

    client = Client(CallbackAPIVersion.VERSION2)
    client.on_message = take
    client.connect("127.0.0.1", broker.port)
    client.subscribe(f"{INTERFACE}/v{vehicle.major}/{vehicle.manufacturer}/{vehicle.serial_number}/+", qos=1)
    client.loop_start()
    try:
        yield heard
    finally:
        client.disconnect()
        client.loop_stop()
