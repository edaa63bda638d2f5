"""How many goals a second go through the service, with robots that take no time.

    uv run python -m benchmarks.throughput [ROUNDS] [SERVER]

A round has a goal for each of the store's four samples. Proposed: until each has a plan to decide on; goals of
IN_FLIGHT streams are open at a time. Finished: approved automatically, organised, dispatched, carried out and reported,
until each is over; a sample's next goal is stated when the one before is over, so that four are open at a time and
compete for the robots: nearly all have to wait for the mission before. Apart: likewise, one sample in each of
WORLDS_APART stores, where no mission waits for another. On SQLite and on a database of the server. Beside that what a
goal costs, which other load changes less: CPU milliseconds of the service's process, with the benchmark's client and
robots, and of the planning processes, and SQL statements.
"""

import os
import sys
import tempfile
import threading
import time
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from fastapi.testclient import TestClient
from sqlalchemy import Engine, event

from app.composition import RunningWorld, Service, make_engine
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.process_tree import tree_of
from app.settings import Settings
from app.store.event_log import EventLog
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
WORLDS_APART = 2
"""Further stores, each with one sample that moves."""
STORE = "sample_store"
WAY = ("bay_6", "bay_1")
"""Where a sample is carried in turn by the one robot of its aisle."""
PROCESSES = 2
"""Planning processes, as many as the service has unless told otherwise."""
GIVE_UP_S = 300.0
START_S = 30.0
"""Longest wait for the other planning process, which starts once work finds none free."""
RECEIVE_S = 0.02
IN_FLIGHT = 8
"""Streams of goals that only get a plan, each stated when the one before has its plan."""
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


@dataclass(frozen=True, slots=True)
class Wish:
    """A goal to state."""

    text: str
    world: str = STORE


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


def through(
    api: TestClient, events: EventLog, streams: Collection[Sequence[Wish]], *, finished: bool
) -> Throughput:
    """Put streams of goals through, each once the one before in its stream has a plan, or is over.

    :param finished: until they are over. :raises TimeoutError: if nothing happens for too long.
    """
    began_s = time.perf_counter()
    service_s, planning_s = time.process_time(), _children_s()
    with counted_statements() as statements:
        _put_through(api, events, streams, finished=finished)
    goals = sum(map(len, streams))
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


def _put_through(
    api: TestClient, events: EventLog, streams: Collection[Sequence[Wish]], *, finished: bool
) -> None:
    passed = "goal.finished" if finished else "goal.planned"
    seen = events.last()
    left = [iter(stream) for stream in streams]
    open_goals: dict[str, Iterator[Wish]] = {}

    def state_next(stream: Iterator[Wish]) -> None:
        for wish in stream:
            goal = {"text": wish.text, "world": wish.world, "auto_approve": finished}
            open_goals[api.post("/v1/goals", json=goal).raise_for_status().json()["id"]] = stream
            return

    for stream in left:
        state_next(stream)
    generation = events.generation
    while open_goals:
        now = events.wait(generation, GIVE_UP_S)
        if now == generation:
            raise TimeoutError(f"nothing has happened for {GIVE_UP_S:.0f} s; open: {', '.join(open_goals)}")
        generation = now
        for one in events.since(seen):
            seen = one.seq
            if one.type == passed and one.subject in open_goals:
                state_next(open_goals.pop(one.subject))
            elif one.type == "goal.unsolvable":
                raise RuntimeError(f"{one.subject}: {one.data['reason']}")


def streams_of(rounds: Sequence[int], *, finished: bool) -> Collection[Sequence[Wish]]:
    """The goals of some rounds: of each sample in turn, or dealt to `IN_FLIGHT` streams."""
    of_sample = [
        [
            Wish(f"move sample_{sample + 1} to bay_{(number * SAMPLES + sample) % BAYS + 1}")
            for number in rounds
        ]
        for sample in range(SAMPLES)
    ]
    if finished:
        return of_sample
    wishes = [wish for of_round in zip(*of_sample, strict=True) for wish in of_round]
    return [wishes[first::IN_FLIGHT] for first in range(IN_FLIGHT)]


def streams_apart(rounds: Sequence[int]) -> Collection[Sequence[Wish]]:
    """One sample's goals in each store of its own."""
    return [
        [Wish(f"move sample_1 to {WAY[number % len(WAY)]}", world) for number in rounds] for world in _apart()
    ]


def _apart() -> Sequence[str]:
    return [f"store_apart_{number + 1}" for number in range(WORLDS_APART)]


def untrue_after(rounds: int) -> Sequence[int]:
    """As many rounds whose goals are not true after those: a goal that is true already has no plan."""
    again = BAYS // SAMPLES
    return [number for number in range(rounds + 1, 3 * rounds + again) if (number - rounds) % again][:rounds]


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """Of goals until they have a plan, until they are finished, and likewise where none waits for another."""

    planned: Throughput
    finished: Throughput
    apart: Throughput


def figures(url: str | None, worker: PlanningWorker, rounds: int) -> Figures:
    with ExitStack() as stack:
        worlds = [stack.enter_context(_world(name)) for name in (STORE, *_apart())]
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        settings = Settings(data=folder, token=TOKEN, database_url=url)
        service = stack.enter_context(Service(settings, worlds, worker=worker))
        bearer = {"authorization": f"Bearer {TOKEN}"}
        api = stack.enter_context(TestClient(service.api, headers=bearer))
        put = partial(through, api, service.events)
        # Not counted: each sample gets a place that no other sample ever goes to, and the other process starts.
        put(streams_of(range(1), finished=True), finished=True)
        put(streams_apart(range(2)), finished=True)
        started_s = time.monotonic()
        while worker.free_count < PROCESSES and time.monotonic() < started_s + START_S:
            time.sleep(RECEIVE_S)
        finished = put(streams_of(range(1, rounds + 1), finished=True), finished=True)
        apart = put(streams_apart(range(rounds * SAMPLES // WORLDS_APART)), finished=True)
        planned = put(streams_of(untrue_after(rounds), finished=False), finished=False)
    return Figures(planned=planned, finished=finished, apart=apart)


@contextmanager
def _world(name: str) -> Iterator[RunningWorld]:
    near, far = InMemoryLink.pair()
    clock = ManualClock()
    file = load_world(STORE).model_copy(update={"name": name})
    with Instant(far, clock):
        yield RunningWorld(file=file, link=near, clock=clock, rate=None, run="benchmark")


def measure(url: str | None, worker: PlanningWorker, rounds: int) -> str:
    found = figures(url, worker, rounds)
    return (
        f"{found.planned.a_second:.1f} goals a second proposed, {found.finished.a_second:.1f} finished,"
        f" {found.apart.a_second:.1f} finished apart; a goal costs {found.planned.cost} to its plan,"
        f" {found.finished.cost} to its end, {found.apart.cost} apart"
    )


def main(rounds: int = 10, server: str = SERVER) -> None:
    worker = PlanningWorker(make_engine, processes=PROCESSES)
    worker.warm_up().result()
    print(f"SQLite: {measure(None, worker, rounds)}", flush=True)
    with database_on(server) as url:
        print(f"PostgreSQL: {measure(url, worker, rounds)}", flush=True)
    worker.close()


if __name__ == "__main__":
    main(*(convert(given) for convert, given in zip((int, str), sys.argv[1:], strict=False)))
