"""How much slower each request is with a large record than with a small one: `python -m benchmarks.growth`.

Two services run side by side, each after one mission; the record is then filled with copies of it. Every GET of the
API is made of both in turn, and goals are planned, approved and carried out. Prints for each the CPU milliseconds of
the service's process and its database connections, and the wall-clock milliseconds, medians, small and large record.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import psycopg

from benchmarks.databases import SERVER, database_on
from benchmarks.growth.record import LARGE, SMALL, Size, fill
from benchmarks.growth.requests import Record, Request, approve, reads, submit, wait
from benchmarks.processes import cpu_s
from tests.scenarios.serving import Served, macta_serve

DATABASES = ("sqlite", "postgresql")
SPEED = 5
REPEATS = 5
"""Requests in a row, whose CPU time is measured together."""
IDLE_S = 10.0
WORD = "move sample_{} to bay_{}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """A service with its record, and its process and database connections."""

    record: Record
    served: Served
    database: str | None

    def cpu_s(self) -> float:
        return sum(cpu_s(pid) for pid in (self.served.process.pid, *self._backends()))

    def _backends(self) -> list[int]:
        if self.database is None:
            return []
        with psycopg.connect(self.database.replace("+psycopg", ""), autocommit=True) as connection:
            found = connection.execute("SELECT pid FROM pg_stat_activity WHERE datname = current_database()")
            return [pid for (pid,) in found if pid != connection.info.backend_pid]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    cpu_ms: float
    wall_ms: float
    answered: int = 0


@contextmanager
def side(server: str | None, size: Size) -> Iterator[Side]:
    """A service whose record has the size; the record is filled while no service runs."""
    with ExitStack() as parts:
        folder = Path(parts.enter_context(TemporaryDirectory()))
        url = parts.enter_context(database_on(server) if server else nullcontext())
        variables = {"token": "a-token-of-the-benchmark"} | ({"database_url": url} if url else {})
        with macta_serve(folder, "--speed", str(SPEED), **variables) as first, first.client() as api:
            wish = {"text": WORD.format(1, 7), "auto_approve": True}
            goal = api.post("/v1/goals", json=wish).raise_for_status().json()["id"]
            wait(Record(api=api, names={}, carried_out=""), f"/v1/goals/{goal}", "finished")
            mission = api.get(f"/v1/goals/{goal}").json()["mission_id"]
        begun_s = time.monotonic()
        fill(url or f"sqlite:///{folder / 'macta.sqlite'}", size)
        print(f"filled with {size} in {time.monotonic() - begun_s:.0f} s", flush=True)
        served = parts.enter_context(macta_serve(folder, "--speed", str(SPEED), **variables))
        api = parts.enter_context(served.client())
        yield Side(record=Record.of(api, size, mission), served=served, database=url)


def cost(side: Side, request: Request) -> Cost:
    """Of one request; the CPU time is that of several in a row."""
    walls_s = []
    before_s = side.cpu_s()
    for _ in range(REPEATS):
        begun_s = time.perf_counter()
        answered = request(side.record)
        walls_s.append(time.perf_counter() - begun_s)
    used_s = side.cpu_s() - before_s
    return Cost(cpu_ms=1000 * used_s / REPEATS, wall_ms=1000 * median(walls_s), answered=answered)


def compare(name: str, sides: tuple[Side, Side], measure: Callable[[Side], Cost], rounds: int) -> None:
    """Measure both in turn, and print the medians and their ratios."""
    found = [[measure(one) for one in sides] for _ in range(rounds)]
    small, large = zip(*found, strict=True)
    cpus, walls = (
        [median(getattr(cost, what) for cost in costs) for costs in (small, large)]
        for what in ("cpu_ms", "wall_ms")
    )
    answers = (
        "" if small[0].answered == large[0].answered else f"  ({small[0].answered}, {large[0].answered})"
    )
    print(
        f"{name:62s} {cpus[0]:8.1f} {cpus[1]:8.1f} {cpus[1] / max(cpus[0], 1e-3):6.2f}"
        f" {walls[0]:8.1f} {walls[1]:8.1f} {walls[1] / walls[0]:6.2f}{answers}",
        flush=True,
    )


def timed(side: Side, *steps: Callable[[], object]) -> list[Cost]:
    """The costs of steps that follow each other."""
    costs = []
    for step in steps:
        begun_s, before_s = time.perf_counter(), side.cpu_s()
        step()
        costs.append(
            Cost(cpu_ms=1000 * (side.cpu_s() - before_s), wall_ms=1000 * (time.perf_counter() - begun_s))
        )
    return costs


def operate(sides: tuple[Side, Side], rounds: int) -> None:
    """A goal's way from its submission to the mission's end, on both in turn."""
    names = (
        "POST /v1/goals, accepted",
        "… until it is planned",
        "POST :approve",
        "… until the mission has ended",
        "idle, 10 s",
    )
    found: list[list[list[Cost]]] = []
    for number in range(rounds):
        found.append([_operate(one, WORD.format(number % 3 + 2, number % 3 + 8)) for one in sides])
    for index, name in enumerate(names):
        costs = {id(one): iter([both[place][index] for both in found]) for place, one in enumerate(sides)}
        compare(name, sides, lambda one, costs=costs: next(costs[id(one)]), rounds)  # type: ignore[misc]


def _operate(one: Side, text: str) -> list[Cost]:
    ids: dict[str, str] = {}
    record = one.record
    return timed(
        one,
        lambda: ids.update(goal=submit(record, text)),
        lambda: wait(record, f"/v1/goals/{ids['goal']}", "planned"),
        lambda: ids.update(mission=approve(record, ids["goal"])),
        lambda: wait(record, f"/v1/missions/{ids['mission']}", "completed", "failed", "partially_completed"),
        lambda: time.sleep(IDLE_S),
    )


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--database", choices=DATABASES, action="append", help="default: both")
    options.add_argument("--rounds", type=int, default=5)
    options.add_argument("--server", default=SERVER)
    options.add_argument("--events", type=int, default=LARGE.events)
    options.add_argument("--goals", type=int, default=LARGE.goals)
    options.add_argument("--missions", type=int, default=LARGE.missions)
    options.add_argument("--only", default="", help="requests whose name contains this")
    given = options.parse_args()
    large = Size(events=given.events, goals=given.goals, missions=given.missions)
    for database in given.database or DATABASES:
        server = given.server if database == "postgresql" else None
        with side(server, SMALL) as one, side(server, large) as other:
            sides = (one, other)
            print(f"{database:62s} {'CPU ms small, large, ratio':>24s} {'wall ms small, large, ratio':>25s}")
            for name, request in reads(one.record.api):
                if given.only in name:
                    for each in sides:
                        request(each.record)
                    compare(name, sides, lambda each, ask=request: cost(each, ask), given.rounds)  # type: ignore[misc]
            if not given.only:
                operate(sides, given.rounds)


if __name__ == "__main__":
    main()
