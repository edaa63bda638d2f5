"""A service and a fleet that reach each other by the link of an installed package, instead of a broker."""

import os
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.cli.long_running import world_over_broker
from app.composition import Service
from app.domain.errors import Invalid
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.world import load_world
from tests.packages import installed, write_package
from tests.scenarios.services import AUTHORISED, TOKEN
from tests.scenarios.serving import macta_fleet
from tests.waiting import awaited, in_state, read_until

ENTRY_POINTS = """\
[macta.links]
wire = socket_link:SocketTransport
torn = socket_link:torn
"""

PYTHON = '''\
"""Messages over a local socket: the service listens, the fleet calls it."""

import time
from collections import deque
from contextlib import suppress
from multiprocessing.connection import Client, Listener
from threading import Lock, Thread

from robots.link.mqtt import ConnectionState, FollowingClock
from robots.wire import Message, Telemetry


class SocketTransport:
    def __init__(self, address):
        self.path = address.removeprefix("wire://")
        if not self.path.startswith("/"):
            raise ValueError(f"{address!r} is not of the form wire:///PATH")

    def __str__(self):
        return f"wire://{self.path}"

    def service_end(self, world, robots, *, digest):
        return ServiceEnd(self.path, robots)

    def fleet_end(self, world, robots, *, run, digest):
        return FleetEnd(self.path, run)


class ServiceEnd:
    def __init__(self, path, robots):
        self.clock = FollowingClock()
        self.run = None
        self.taken_up = None
        self._robots = robots
        self._listener = Listener(path)
        self._board = None
        self._caller = None
        self._inbox = deque()

    def take_up(self, run):
        self.taken_up = run

    def listen(self, listener):
        self._board = listener

    def start(self):
        Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        with suppress(OSError, EOFError):
            self._caller = self._listener.accept()
            while True:
                self._take(*self._caller.recv())

    def _take(self, kind, *content):
        if kind == "announcement":
            run, time_s, rate = content
            self.run = run
            self.clock.set(run, time_s, rate, running=True)
            for robot in self._robots:
                self._board.connected(robot, ConnectionState.ONLINE, now=True)
        elif self.taken_up is not None:
            message = Message.model_validate_json(content[0])
            if isinstance(message.body, Telemetry):
                self._board.heard(message.sender, message.body)
            else:
                self._inbox.append(message)

    def send(self, message):
        if self.taken_up is not None and self._caller is not None:
            with suppress(OSError):
                self._caller.send(message.model_dump_json())

    def receive(self, timeout_s=0.0):
        if not self._inbox:
            time.sleep(min(timeout_s, 0.02))
        return [self._inbox.popleft() for _ in range(len(self._inbox))]

    def close(self):
        self._listener.close()
        if self._caller is not None:
            self._caller.close()


class FleetEnd:
    complaint = ""
    refused = False
    superseded = False

    def __init__(self, path, run):
        self._path = path
        self._run = run
        self._called = None
        self._announced_s = 0.0

    @property
    def connected(self):
        return self._called is not None

    def start(self):
        self._called = Client(self._path)

    def announce(self, time_s, rate):
        if time.monotonic() - self._announced_s > 0.1:
            self._announced_s = time.monotonic()
            self._send("announcement", self._run, time_s, rate)

    def send(self, message):
        self._send("message", message.model_dump_json())

    def _send(self, *content):
        with suppress(OSError):
            self._called.send(content)

    def receive(self, timeout_s=0.0):
        arrived = []
        with suppress(OSError, EOFError):
            while self._called.poll(0):
                arrived.append(Message.model_validate_json(self._called.recv()))
        return arrived

    def close(self):
        self._called.close()


def torn(address):
    raise ValueError("the wire is torn")
'''


@pytest.fixture
def site(tmp_path: Path) -> Path:
    return write_package(tmp_path / "site", "socket_link", ENTRY_POINTS, {"socket_link.py": PYTHON})


def test_a_mission_runs_over_a_packages_link(
    site: Path, tmp_path: Path, worker: PlanningWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    address = f"wire://{tmp_path / 'socket'}"
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), os.getcwd()]))
    settings = Settings(data=tmp_path / "service", token=TOKEN, database_url=None, broker_url=address)
    with installed(site):
        transport = settings.broker()
    assert transport is not None
    assert str(transport) == address
    with (
        world_over_broker(transport, load_world("sample_store")) as running,
        Service(settings, [running], worker=worker) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
        macta_fleet(tmp_path / "fleet", "--broker", address, "--speed", "10"),
    ):
        awaited(
            lambda: {robot["connection"] for robot in api.get("/v1/robots").json()["items"]},
            {"online"}.__eq__,
        )
        goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
        committed = read_until(api, f"/v1/goals/{goal['id']}", lambda one: one["mission_id"] is not None)
        mission = f"/v1/missions/{committed['mission_id']}"
        ended = in_state(api, mission, "completed", "partially_completed", "failed", "cancelled")
        assert ended["state"] == "completed", ended["reason"]


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("wire://socket", "is not of the form wire:///PATH"),
        ("torn:///socket", "the wire is torn"),
        ("string:///socket", "no link for string://; choices: mqtt, mqtts, torn, wire"),
    ],
)
def test_an_address_that_is_none_is_refused(site: Path, address: str, words: str) -> None:
    with installed(site), pytest.raises(Invalid) as refused:
        Settings(broker_url=address).broker()
    assert refused.value.detail.startswith("MACTA_BROKER_URL: ")
    assert words in refused.value.detail
