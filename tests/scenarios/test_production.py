"""The production shape: two APIs, two workers and a fleet, on PostgreSQL and Mosquitto; any of them may die."""

import json
import os
import re
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx2
import pytest

from examples.production import Running, end_all, start_all
from tests.databases import ON_POSTGRESQL
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto

TOKEN = "a-token-for-the-tests"
START_S, GIVE_UP_S = 400.0, 150.0
Body = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """The processes, and a client of each API."""

    processes: Sequence[Running]
    clients: Mapping[int, httpx2.Client]

    def named(self, name: str) -> Running:
        return next(running for running in self.processes if running.name == name)

    def kill(self, pid: int) -> None:
        """The process dies with its children, as a machine would."""
        os.killpg(pid, signal.SIGKILL)


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def shape(database_url: str, broker: Mosquitto, tmp_path: Path) -> Iterator[Shape]:
    database = urlsplit(database_url)
    given = {
        "MACTA_TOKEN": TOKEN,
        "MACTA_DATABASE_HOST": database.hostname or "",
        "MACTA_DATABASE_PORT": str(database.port),
        "MACTA_DATABASE_USER": database.username or "",
        "MACTA_DATABASE_PASSWORD": database.password or "unused",
        "MACTA_DATABASE_NAME": database.path.lstrip("/"),
        "MACTA_BROKER_URL": broker.url,
        "MACTA_PLANNING_PROCESSES": "1",
        "MACTA_SPEED": "4",
    }
    processes = start_all(tmp_path, given)
    try:
        give_up = time.monotonic() + START_S
        for running in processes:
            ready = running.ready.wait(max(give_up - time.monotonic(), 0.0))
            assert ready, f"{running.name} is not ready, {running.process.poll()}"
        with ExitStack() as clients:
            apis = {r.process.pid: clients.enter_context(_client(r)) for r in processes if _address(r)}
            yield Shape(processes=processes, clients=apis)
    finally:
        end_all(processes)


def _address(running: Running) -> str:
    found = re.search(r"http://\S+(?=/\?token)", running.said)
    return found[0] if found else ""


def _client(running: Running) -> httpx2.Client:
    headers = {"authorization": f"Bearer {TOKEN}"}
    return httpx2.Client(base_url=_address(running), headers=headers, timeout=30)


def until(read: Callable[[], Body], *states: str) -> Body:
    give_up = time.monotonic() + GIVE_UP_S
    while (thing := read())["state"] not in states:
        assert time.monotonic() < give_up, thing
        time.sleep(0.1)
    return thing


@needs_mosquitto
@pytest.mark.timeout(900)
@ON_POSTGRESQL
def test_a_mission_survives_the_death_of_an_api_and_of_a_worker(shape: Shape) -> None:
    any_api = next(iter(shape.clients.values()))
    known = [one for one in any_api.get("/v1/executors").json()["items"] if one["alive"]]
    speaking = next(one["pid"] for one in known if one["worlds"])
    assert sorted(one["serves"] for one in known) == [["missions"]] * 2 + [["planning", "waiting"]] * 2
    dying, other = shape.clients[speaking], shape.clients[next(p for p in shape.clients if p != speaking)]

    # A goal stated at one is approved at the other, and seen at both.
    goal = dying.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
    plan = until(lambda: other.get(f"/v1/goals/{goal['id']}").json(), "planned")["plan_id"]
    missions = [api.post(f"/v1/plans/{plan}:approve").json()["mission_id"] for api in (other, dying)]
    assert missions[0] == missions[1]
    path = f"/v1/missions/{missions[0]}"
    until(lambda: dying.get(path).json(), "running")
    seen = [event["seq"] for event in _events(dying, after=0)]

    shape.kill(speaking)
    shape.kill(shape.named("worker-1").process.pid)
    assert until(lambda: other.get(path).json(), "completed", "failed", "unknown")["state"] == "completed"
    facts = other.get("/v1/worlds/sample_store/facts").json()["items"]
    assert ["in", ["sample_1", "bay_7"]] in [[fact["predicate"], fact["args"]] for fact in facts]

    # What was read at the dead one is resumed at the other, and the worker that is left plans.
    later = [event["seq"] for event in _events(other, after=seen[-1])]
    assert [*seen, *later] == [event["seq"] for event in _events(other, after=0)]
    assert [*seen, *later] == sorted({*seen, *later})
    goal = other.post("/v1/goals", json={"text": "move sample_2 to bay_3"}).json()
    until(lambda: other.get(f"/v1/goals/{goal['id']}").json(), "planned")
    assert httpx2.get(f"{other.base_url}/readyz").json() == {"status": "ready"}


def _events(api: httpx2.Client, *, after: int) -> list[dict[str, Any]]:
    """The events that there are after a number."""
    newest: list[dict[str, Any]] = []
    with api.stream("GET", f"/v1/events?after={after}", timeout=2) as answer:
        try:
            for line in answer.iter_lines():
                if line.startswith("data:"):
                    newest.append(json.loads(line[5:]))
        except httpx2.ReadTimeout:
            pass
    return newest
