"""Takeover time: from kill -9 of an executor until another one continues its workflow.

uv run python -m benchmarks.recovery [RUNS] [SERVER]
"""

import statistics
import subprocess
import sys
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager

from app.domain.events import RobotFound
from app.store import Database
from app.store.event_log import EventLog
from app.store.migrate import migrate
from app.workflows import MISSIONS, Workflows, sleep_until_woken, step
from app.workflows.leases import ExecutorRegistry
from benchmarks.databases import SERVER, database_on

TICK_S = 0.1
GIVE_UP_S = 60.0
EXECUTE, BEGINS = "--execute", "begins"


def takeover_s(url: str) -> float:
    """Seconds from the death of the executor that runs a workflow to the workflow's next step, in another process.

    :raises TimeoutError: if it does not go on within a minute.
    """
    database = Database(url)
    migrate(database)
    log = EventLog(database)
    with _executor(url, "idle") as idle, _executor(url, BEGINS) as begins:
        processes = {"idle": idle, BEGINS: begins}
        runs = _ticks_of(processes, log, after=0)
        dying = processes.pop(runs)
        dying.kill()
        dying.wait()
        killed, seen = time.perf_counter(), log.last()
        _ticks_of(processes, log, after=seen)
        took_s = time.perf_counter() - killed
    database.close()
    return took_s


@contextmanager
def _executor(url: str, name: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "benchmarks.recovery", EXECUTE, url, name]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        process.stdout.readline()
        yield process
    finally:
        process.kill()
        process.communicate()


def _ticks_of(names: Collection[str], log: EventLog, *, after: int) -> str:
    """The process of these in which the workflow runs."""
    give_up = time.monotonic() + GIVE_UP_S
    while time.monotonic() < give_up:
        if ticking := [event.subject for event in log.since(after) if event.subject in names]:
            return ticking[0]
        time.sleep(0.02)
    raise TimeoutError(f"the workflow runs in none of {', '.join(names)}")


def execute(url: str, name: str) -> None:
    """Run as an executor until killed; `BEGINS` starts an endless workflow."""
    database = Database(url)
    log = EventLog(database)
    workflows = Workflows(url)

    def tick() -> None:
        with database.write() as session:
            log.append(session, RobotFound(subject=name, world="", actor="", comment=""))

    def life(_: str) -> None:
        while True:
            step("tick", tick)
            sleep_until_woken(TICK_S)

    workflows.register("life", life)
    presence = ExecutorRegistry(database, workflows, serves=[MISSIONS.name], worlds=())
    presence.register()
    workflows.launch()
    presence.start()
    if name == BEGINS:
        with database.write() as session:
            workflows.start(session, MISSIONS, "life", "life", "life")
    print("ready", flush=True)
    time.sleep(10 * GIVE_UP_S)


def main(runs: int = 5, server: str = SERVER) -> None:
    took: list[float] = []
    for _ in range(runs):
        with database_on(server) as url:
            took.append(takeover_s(url))
            print(f"{took[-1]:.1f} s", flush=True)
    print(f"median {statistics.median(took):.1f} s, {min(took):.1f} to {max(took):.1f} s, {runs} runs")


if __name__ == "__main__":
    if sys.argv[1:2] == [EXECUTE]:
        execute(*sys.argv[2:4])
    else:
        main(*(convert(given) for convert, given in zip((int, str), sys.argv[1:], strict=False)))
