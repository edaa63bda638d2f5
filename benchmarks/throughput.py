"""How many goals a second go through the service, with robots that take no time.

    uv run python -m benchmarks.throughput [ROUNDS] [SERVER]

Each round states a goal for each of the store's four samples at once. Proposed: until each has a plan to decide on.
Finished: approved automatically, organised, dispatched, carried out and reported, until each is over. On SQLite and
on a database of the server.
"""

import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service, make_engine
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from benchmarks.databases import SERVER, database_on
from robots.clock import ManualClock
from robots.link import InMemoryLink, Link
from robots.wire import Acknowledgement, Message, Performative, ScriptReport, ScriptRequest, ScriptState
from robots.world import load_world

TOKEN = "a-token-of-the-benchmark"
SAMPLES, BAYS = 4, 12
GIVE_UP_S = 300.0
LOOK_S = 0.01


class Instant:
    """Robots that finish every script at once."""

    def __init__(self, link: Link) -> None:
        self._link, self._ending = link, threading.Event()
        self._done: set[str] = set()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._ending.is_set():
            for message in self._link.receive(LOOK_S):
                if isinstance(message.body, ScriptRequest) and message.id not in self._done:
                    self._done.add(message.id)
                    self._answer(message, message.body.script.id)

    def _answer(self, message: Message, script_id: str) -> None:
        taken = Acknowledgement(script_id=script_id)
        done = ScriptReport(script_id=script_id, state=ScriptState.FINISHED, at_s=0.0)
        for performative, body, to in (
            (Performative.AGREE, taken, message.id),
            (Performative.INFORM, done, None),
        ):
            self._link.send(
                Message(
                    performative=performative,
                    sender=message.receiver,
                    receiver=message.sender,
                    sent_at_s=0.0,
                    in_reply_to=to,
                    body=body,
                )
            )


def through(api: TestClient, rounds: Sequence[int], *, finished: bool) -> float:
    """Goals a second, until they have a plan or until they are finished.

    :raises TimeoutError: if a round takes too long.
    """
    began = time.perf_counter()
    for number in rounds:
        bays = [(number * SAMPLES + sample) % BAYS + 1 for sample in range(SAMPLES)]
        texts = [f"move sample_{sample + 1} to bay_{bay}" for sample, bay in enumerate(bays)]
        wishes = [{"text": text, "auto_approve": finished} for text in texts]
        goals = [api.post("/v1/goals", json=wish).raise_for_status().json()["id"] for wish in wishes]
        await_all(api, goals, "finished" if finished else "planned")
    return len(rounds) * SAMPLES / (time.perf_counter() - began)


def await_all(api: TestClient, goals: Sequence[str], state: str) -> None:
    give_up = time.monotonic() + GIVE_UP_S
    left = set(goals)
    while left:
        seen = {goal: api.get(f"/v1/goals/{goal}").json() for goal in left}
        left = {goal for goal, now in seen.items() if now["state"] != state}
        if time.monotonic() > give_up:
            raise TimeoutError(f"not {state}: {[seen[goal] for goal in left]}")
        time.sleep(LOOK_S)


def measure(url: str | None, worker: PlanningWorker, rounds: int) -> str:
    near, far = InMemoryLink.pair()
    world = RunningWorld(
        file=load_world("sample_store"), link=near, clock=ManualClock(), rate=None, run="benchmark"
    )
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data=Path(folder), token=TOKEN, database_url=url)
        with (
            Instant(far),
            Service(settings, [world], worker=worker) as service,
            TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api,
        ):
            done = through(api, range(rounds), finished=True)
            planned = through(api, range(rounds, 2 * rounds), finished=False)
    return f"{planned:.1f} goals a second proposed, {done:.1f} finished"


def main(rounds: int = 10, server: str = SERVER) -> None:
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    print(f"SQLite: {measure(None, worker, rounds)}", flush=True)
    with database_on(server) as url:
        print(f"PostgreSQL: {measure(url, worker, rounds)}", flush=True)
    worker.close()


if __name__ == "__main__":
    main(*(convert(given) for convert, given in zip((int, str), sys.argv[1:], strict=False)))
