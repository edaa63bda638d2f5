"""A storm of kills: `macta serve` and everything it started is ended by SIGKILL, again and again, at any instant.

Goals are stated under idempotency keys until they are accepted, and approved automatically. Afterwards the record is
compared with the simulated world's last snapshot.
"""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2
from sqlalchemy import select

from app.database import Database, MessageRow
from robots.world import load_world
from sim.agents import behavioural_agent
from sim.snapshot import WorldSnapshot
from sim.truth import Truth
from sim.world import Simulation

WORLD = "sample_store"
TOKEN = "a-token-for-the-storm"
GIVE_UP_S = 600.0
ENDED = ("finished", "withdrawn", "unsolvable")
DEADLINE_S = 5000.0


@dataclass
class Storm:
    """What is done and what is seen. `environment`: settings of the service, such as another database.

    :param goals: by idempotency key, the sentence.
    :param early: of the kills so many come before the service is ready, the others up to `latest_s` after.
    """

    data: Path
    goals: Mapping[str, str]
    seed: int
    kills: int
    early: int = 1
    latest_s: float = 8.0
    speed: float = 6.0
    environment: Mapping[str, str] = field(default_factory=dict)
    accepted: dict[str, str] = field(default_factory=dict)
    """Goals' ids by their keys."""
    deadlines: dict[str, set[float]] = field(default_factory=dict)
    """By goal, every instant that its deadline was said to be at."""
    clock_s: list[float] = field(default_factory=list)
    """The world's time, as it was read one time after the other."""
    complaints: list[str] = field(default_factory=list)
    final: list[dict[str, Any]] = field(default_factory=list)

    def rage(self) -> None:
        """All kills, and then a life in which everything comes to its end."""
        rng = random.Random(self.seed)
        early = set(rng.sample(range(1, self.kills), self.early))
        for life in range(self.kills):
            with self._served(life) as process:
                if life in early:
                    time.sleep(rng.uniform(0.3, 4.0))
                else:
                    address = self._ready(life, process)
                    killer = threading.Timer(rng.uniform(0.3, self.latest_s), kill_family, [process.pid])
                    killer.start()
                    with suppress(httpx2.TransportError):  # it is cut off
                        self._use(address, lambda: process.poll() is None)
                    killer.join()
                kill_family(process.pid)
        with self._served(self.kills) as process:
            address = self._ready(self.kills, process)
            self._use(address, lambda: not self._over())
            process.send_signal(signal.SIGTERM)
            process.wait(timeout=60)

    def _over(self) -> bool:
        return len(self.final) == len(self.goals) and all(goal["state"] in ENDED for goal in self.final)

    @contextmanager
    def _served(self, life: int) -> Iterator[subprocess.Popen[bytes]]:
        command = [sys.executable, "-c", "from app.cli import main; main()", "serve", "--port", "0"]
        options = ["--data", str(self.data), "--world", WORLD, "--speed", str(self.speed)]
        outside = {k: v for k, v in os.environ.items() if not k.startswith("MACTA_")}
        with self._said(life, "out").open("wb") as out, self._said(life, "err").open("wb") as err:
            process = subprocess.Popen(
                [*command, *options],
                stdout=out,
                stderr=err,
                env={**outside, "MACTA_TOKEN": TOKEN, **self.environment},
            )
        try:
            yield process
        finally:
            kill_family(process.pid)
            process.wait()
            self.complaints.append(self._said(life, "err").read_text())

    def _said(self, life: int, where: str) -> Path:
        return self.data.parent / f"life_{life}.{where}"

    def _ready(self, life: int, process: subprocess.Popen[bytes]) -> str:
        give_up = time.monotonic() + GIVE_UP_S
        while not (said := self._said(life, "out").read_text()).endswith("\n"):
            assert process.poll() is None, self._said(life, "err").read_text()
            assert time.monotonic() < give_up, "not ready"
            time.sleep(0.05)
        return said.partition("ready: ")[2].partition("/?token")[0]

    def _use(self, address: str, go_on: Callable[[], bool]) -> None:
        """State every goal, those that are accepted once more, and look on."""
        give_up = time.monotonic() + GIVE_UP_S
        headers = {"authorization": f"Bearer {TOKEN}"}
        with httpx2.Client(base_url=address, headers=headers, timeout=20) as api:
            for key, text in self.goals.items():
                self._state(api, key, text)
            while go_on():
                assert time.monotonic() < give_up, self.final
                self._look(api)
                time.sleep(0.1)

    def _state(self, api: httpx2.Client, key: str, text: str) -> None:
        body = {"world": WORLD, "text": text, "auto_approve": True, "deadline_s": DEADLINE_S}
        answer = api.post("/v1/goals", json=body, headers={"idempotency-key": key})
        assert answer.status_code == 202, answer.text
        goal_id = answer.json()["id"]
        assert self.accepted.setdefault(key, goal_id) == goal_id

    def _look(self, api: httpx2.Client) -> None:
        self.clock_s.append(api.get(f"/v1/worlds/{WORLD}").json()["time_s"])
        self.final = [api.get(f"/v1/goals/{goal_id}").json() for goal_id in self.accepted.values()]
        for goal in self.final:
            self.deadlines.setdefault(goal["id"], set()).add(goal["deadline_at_s"])

    def truth(self) -> Truth:
        """The world as its last snapshot has it."""
        return truth_of(self.data)

    def executed(self) -> Mapping[tuple[str, str, str], int]:
        """As the function of that name, by this storm's record."""
        return executed(self.environment.get("MACTA_DATABASE_URL", f"sqlite:///{self.data}/macta.sqlite"))


def truth_of(data: Path) -> Truth:
    """The world as the last snapshot in a data folder has it."""
    snapshot = WorldSnapshot.model_validate_json((data / "worlds" / f"{WORLD}.json").read_bytes())
    return Simulation(load_world(WORLD), make_agent=behavioural_agent, snapshot=snapshot).truth()


def executed(database_url: str) -> Mapping[tuple[str, str, str], int]:
    """How often each packet's begin and end, and each script's end, was recorded: by script, packet and state."""
    database = Database(database_url)
    with database.read() as session:
        messages = session.scalars(select(MessageRow)).all()
    database.close()
    return Counter(_event(row.body["body"]) for row in messages if _tells(row.body["body"]))


def _tells(body: Mapping[str, Any]) -> bool:
    """A packet that begins or ends, or a script that ends; not what is said while one runs."""
    begins = body.get("state") == "running" and not body["detail"] and not body["events"]
    ends = body.get("state") in ("finished", "failed", "cancelled")
    return (body["kind"] == "packet_report" and (begins or ends)) or (
        body["kind"] == "script_report" and ends
    )


def _event(body: Mapping[str, Any]) -> tuple[str, str, str]:
    packet = body["packet_id"] if body["kind"] == "packet_report" else "the script"
    return (body["script_id"], packet, body["state"])


def kill_family(pid: int) -> None:
    """SIGKILL to a process and all that it and its children started."""
    for member in family(pid):
        try:
            os.kill(member, signal.SIGKILL)
        except ProcessLookupError:
            continue


def family(pid: int) -> Sequence[int]:
    """A process, its children and theirs; the eldest first."""
    parents: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text()
            except (FileNotFoundError, ProcessLookupError):
                continue
            parents.setdefault(int(stat.rpartition(")")[2].split()[1]), []).append(int(entry.name))
    found = [pid]
    for member in found:
        found.extend(parents.get(member, ()))
    return found
