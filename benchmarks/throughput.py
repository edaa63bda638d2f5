"""How many goals a second go through the service, with robots that take no time.

    uv run python -m benchmarks.throughput [ROUNDS] [SERVER]

Each round states a goal for each of the store's four samples at once. Proposed: until each has a plan to decide on.
Finished: approved automatically, organised, dispatched, carried out and reported, until each is over. On SQLite and
on a database of the server. Beside that what a goal costs, which other load changes less: CPU milliseconds of the
service's process, with the benchmark's client and robots, and of the planning processes, and SQL statements.
"""

import os
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fastapi.testclient import TestClient
from sqlalchemy import Engine, event

from app.composition import RunningWorld, Service, make_engine
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.process_tree import tree_of
from app.settings import Settings
from benchmarks.databases import SERVER, database_on
from benchmarks.processes import cpu_s
from robots.clock import ManualClock
from robots.link import InMemoryLink, Link
from robots.wire import (
    Acknowledgement,
    BehaviourScript,
    Body,
    Message,
    Performative,
    Receipt,
    ScriptReport,
    ScriptRequest,
    ScriptState,
)
from robots.world import load_world

TOKEN = "a-token-of-the-benchmark"
SAMPLES, BAYS = 4, 12
GIVE_UP_S = 300.0
RECEIVE_S = 0.02
LOOK_S = 0.1
"""Pause between two looks at the open goals: more of them would be measured, too."""
REPEAT_S = 2.0
"""Wall-clock seconds after which a report without a receipt is sent again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Throughput:
    """Goals a second, and what each costs.

    :param planning_ms: CPU milliseconds of the planning processes that are still running at the end.
    """

    a_second: float
    service_ms: float
    planning_ms: float
    statements: float

    @property
    def cost(self) -> str:
        return f"{self.service_ms:.0f} + {self.planning_ms:.0f} CPU-ms, {self.statements:.0f} statements"


class Instant:
    """Robots that finish every script at once: the world's clock jumps to the script's expected end."""

    def __init__(self, link: Link, clock: ManualClock) -> None:
        self._link = link
        self._clock = clock
        self._ending = threading.Event()
        self._taken: set[str] = set()
        self._unconfirmed: dict[str, Message] = {}
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        repeat_at_s = 0.0
        while not self._ending.is_set():
            for message in self._link.receive(RECEIVE_S):
                if isinstance(message.body, Receipt):
                    self._unconfirmed.pop(message.in_reply_to or "", None)
                elif isinstance(message.body, ScriptRequest) and message.id not in self._taken:
                    self._taken.add(message.id)
                    self._carry_out(message, message.body.script)
            if time.monotonic() >= repeat_at_s:
                repeat_at_s = time.monotonic() + REPEAT_S
                for report in self._unconfirmed.values():
                    self._link.send(report)

    def _carry_out(self, message: Message, script: BehaviourScript) -> None:
        now_s = self._clock.now_s()
        self._send(message, Performative.AGREE, Acknowledgement(script_id=script.id), now_s)
        last = script.packets[-1]
        ended_s = now_s + last.expected_start_s + last.expected_duration_s
        self._clock.advance(ended_s - now_s)
        done = ScriptReport(script_id=script.id, state=ScriptState.FINISHED, at_s=ended_s)
        report = self._send(message, Performative.INFORM, done, ended_s)
        self._unconfirmed[report.id] = report

    def _send(self, to: Message, performative: Performative, body: Body, at_s: float) -> Message:
        answer = Message(
            performative=performative,
            sender=to.receiver,
            receiver=to.sender,
            sent_at_s=at_s,
            in_reply_to=to.id if performative is Performative.AGREE else None,
            body=body,
        )
        self._link.send(answer)
        return answer


def through(api: TestClient, rounds: Sequence[int], *, finished: bool) -> Throughput:
    """Put goals through, until they have a plan or until they are finished.

    :raises TimeoutError: if a round takes too long.
    """
    began_s = time.perf_counter()
    service_s, planning_s = time.process_time(), _children_s()
    with counted_statements() as statements:
        _put_through(api, rounds, finished=finished)
    goals = len(rounds) * SAMPLES
    return Throughput(
        a_second=goals / (time.perf_counter() - began_s),
        service_ms=1000 * (time.process_time() - service_s) / goals,
        planning_ms=1000 * (_children_s() - planning_s) / goals,
        statements=len(statements) / goals,
    )


def _children_s() -> float:
    return sum(cpu_s(one.pid) for one in tree_of(os.getpid())[1:])


@contextmanager
def counted_statements() -> Iterator[Sequence[None]]:
    """Has an item for each statement that any engine of this process has executed in the block."""
    executed: list[None] = []

    def count(*_: object) -> None:
        executed.append(None)

    event.listen(Engine, "before_cursor_execute", count)
    try:
        yield executed
    finally:
        event.remove(Engine, "before_cursor_execute", count)


def _put_through(api: TestClient, rounds: Sequence[int], *, finished: bool) -> None:
    for number in rounds:
        bays = [(number * SAMPLES + sample) % BAYS + 1 for sample in range(SAMPLES)]
        texts = [f"move sample_{sample + 1} to bay_{bay}" for sample, bay in enumerate(bays)]
        wishes = [{"text": text, "auto_approve": finished} for text in texts]
        goals = [api.post("/v1/goals", json=wish).raise_for_status().json()["id"] for wish in wishes]
        await_all(api, goals, "finished" if finished else "planned")


def await_all(api: TestClient, goals: Sequence[str], state: str) -> None:
    give_up = time.monotonic() + GIVE_UP_S
    # One after the other: a request costs as much as a part of the service's work for a goal.
    for goal in goals:
        while (seen := api.get(f"/v1/goals/{goal}").json())["state"] != state:
            if time.monotonic() > give_up:
                raise TimeoutError(f"not {state}: {seen}")
            time.sleep(LOOK_S)


def figures(url: str | None, worker: PlanningWorker, rounds: int) -> tuple[Throughput, Throughput]:
    """Until goals have a plan, and until they are finished."""
    near, far = InMemoryLink.pair()
    clock = ManualClock()
    world = RunningWorld(file=load_world("sample_store"), link=near, clock=clock, rate=None, run="benchmark")
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data=Path(folder), token=TOKEN, database_url=url)
        with (
            Instant(far, clock),
            Service(settings, [world], worker=worker) as service,
            TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api,
        ):
            done = through(api, range(rounds), finished=True)
            planned = through(api, range(rounds, 2 * rounds), finished=False)
    return planned, done


def measure(url: str | None, worker: PlanningWorker, rounds: int) -> str:
    planned, done = figures(url, worker, rounds)
    return (
        f"{planned.a_second:.1f} goals a second proposed, {done.a_second:.1f} finished;"
        f" a goal costs {planned.cost} to its plan, {done.cost} to its end"
    )


def main(rounds: int = 10, server: str = SERVER) -> None:
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    print(f"SQLite: {measure(None, worker, rounds)}", flush=True)
    with database_on(server) as url:
        print(f"PostgreSQL: {measure(url, worker, rounds)}", flush=True)
    worker.close()


if __name__ == "__main__":
    main(*(convert(given) for convert, given in zip((int, str), sys.argv[1:], strict=False)))
