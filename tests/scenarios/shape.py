"""The production shape on a database and a broker of its own, which may be killed like any of its processes."""

import random
import re
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import httpx2

from app.cli.trials.observer import event_numbers
from app.workflows.background import Background
from examples.production import Running, Shape
from tests.cluster import Cluster
from tests.mosquitto import Mosquitto
from tests.scenarios.killing import kill_family, process_of_the_world

TOKEN = "a-token-for-the-tests"
START_S, GIVE_UP_S = 400.0, 300.0
LOOK_S = 0.1


@dataclass
class Production:
    """What runs. Whatever process of the shape dies is begun again, as by its supervisor."""

    shape: Shape
    cluster: Cluster
    broker: Mosquitto
    folder: Path
    _supervisor: Background = field(init=False)
    _turns: Iterator[int] = field(default_factory=count, init=False)

    def __post_init__(self) -> None:
        self._supervisor = Background("supervisor", self._supervise)

    @property
    def database_url(self) -> str:
        return self.cluster.url

    @contextmanager
    def run(self) -> Iterator[None]:
        """For the length of the block, from when all are ready."""
        self.shape.look()
        self._supervisor.start()
        try:
            give_up = time.monotonic() + START_S
            while not all(one.ready.is_set() for one in self.processes()):
                assert time.monotonic() < give_up, "not ready"
                time.sleep(LOOK_S)
            yield
        finally:
            self.end()

    def end(self) -> None:
        """In order; safe to call again."""
        self._supervisor.end()
        self.shape.end()

    def processes(self, part: str = "") -> Sequence[Running]:
        """Those there are now, of a part or of all."""
        return [one for name, one in self.shape.running.items() if name.startswith(part)]

    def _supervise(self) -> None:
        while not self._supervisor.ending.wait(LOOK_S):
            self.shape.look()

    def kill_all(self, victims: Sequence[str], rng: random.Random, most_s: float) -> None:
        """Each once, in any order, at most so long after the one before.

        :param victims: `database`, `broker`, `world` for its process alone, or processes of the shape.
        """
        for victim in rng.sample(victims, len(victims)):
            time.sleep(rng.uniform(0.0, most_s))
            if victim in ("database", "broker"):
                server = self.cluster if victim == "database" else self.broker
                server.kill()
                time.sleep(rng.uniform(0.2, 2.0))
                server.start()
            else:
                kill_family(self._pid_of(victim))

    def _pid_of(self, victim: str) -> int:
        if victim != "world":
            return self.shape.running[victim].process.pid
        fleet = self.shape.running["fleet-1"]
        fleet.ready.wait(START_S)  # it may have been killed just now, with its world
        return process_of_the_world(fleet.process.pid, self.folder / "fleet-1")

    def through_any(self, use: Callable[[httpx2.Client, str], None], go_on: Callable[[], bool]) -> None:
        """Have an API used again and again, by turns, whichever answers."""
        give_up = time.monotonic() + GIVE_UP_S
        while go_on():
            for api in self.processes("api"):
                assert time.monotonic() < give_up, f"this takes too long: {told_by(api)}"
                if api.ready.is_set() and go_on():
                    # It may be killed meanwhile, or without its database just now (503).
                    with suppress(httpx2.TransportError, httpx2.HTTPStatusError), client_of(api) as client:
                        use(client, f"{api.name} {api.process.pid}")
            time.sleep(LOOK_S)

    def api(self) -> httpx2.Client:
        """Of one that is ready, each time of another."""
        ready = [one for one in self.processes("api") if one.ready.is_set()]
        return client_of(ready[next(self._turns) % len(ready)])

    def events(self) -> list[int]:
        """The numbers of all events, as one API tells them."""
        seen: list[int] = []

        def read(api: httpx2.Client, _: str) -> None:
            for number in event_numbers(api, 0):
                seen.append(number)

        self.through_any(read, lambda: not seen)
        return seen


def told_by(api: Running) -> str:
    """How everything stands, as an API has it; empty if it does not answer."""
    with suppress(AssertionError, httpx2.HTTPError), client_of(api) as client:
        return "\n".join(client.get(f"/v1/{what}").text for what in ("goals", "missions", "robots"))
    return ""


def address_of(api: Running) -> str:
    found = re.search(r"http://[^/\s]+", api.said)
    assert found is not None, api.said
    return found[0]


def client_of(api: Running) -> httpx2.Client:
    headers = {"authorization": f"Bearer {TOKEN}"}
    return httpx2.Client(base_url=address_of(api), headers=headers, timeout=10, verify=False)  # no TLS
