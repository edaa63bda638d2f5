"""Costs of a running service: its start, its idle hours, goals, missions and requests."""

import http.client
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from app.composition import make_engine
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.process_tree import tree_of
from benchmarks import reads, throughput
from benchmarks.costs.commands import MACTA
from benchmarks.costs.table import Row
from benchmarks.databases import SERVER, database_on
from benchmarks.posting import post, service_on
from benchmarks.processes import environment, pss_mb, tree_cpu_s

LOOK_S = 0.02
GIVE_UP_S = 600.0
SETTLE_S = 20.0
IDLE_S = 30.0
POSTED_S = 30.0
A_SECOND = 50.0
ROUNDS = 5
"""Rounds of four goals in a run of the throughput."""
PORT = 18765


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Seconds from the command to the first answer of 200, and the CPU seconds of all its processes until `/readyz`."""

    healthz_s: float
    readyz_s: float
    cpu_s: float


@contextmanager
def started(cache: Path) -> Iterator[tuple[Start, int]]:
    """How a service started with a record of its own, and its process."""
    with TemporaryDirectory() as data:
        begun_s = time.perf_counter()
        service = subprocess.Popen(
            [*MACTA, "serve", "--port", str(PORT), "--data", data],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment(cache),
        )
        try:
            _await("/healthz", service)
            healthz_s = time.perf_counter() - begun_s
            _await("/readyz", service)
            readyz_s = time.perf_counter() - begun_s
            yield Start(healthz_s=healthz_s, readyz_s=readyz_s, cpu_s=tree_cpu_s(service.pid)), service.pid
        finally:
            service.terminate()
            service.wait()


def _await(path: str, service: subprocess.Popen[bytes]) -> None:
    """:raises TimeoutError: if the path is not answered with 200 in time."""
    give_up_s = time.monotonic() + GIVE_UP_S
    while time.monotonic() < give_up_s and service.poll() is None:
        client = http.client.HTTPConnection("127.0.0.1", PORT, timeout=10)
        try:
            client.request("GET", path)
            if client.getresponse().status == http.HTTPStatus.OK:
                return
        except OSError:
            pass
        finally:
            client.close()
        time.sleep(LOOK_S)
    raise TimeoutError(f"macta serve did not answer {path}")


def start(runs: int) -> Iterator[Row]:
    """Each time first with an empty cache of compiled code, then with what the first start left."""
    cold: list[Start] = []
    warm: list[Start] = []
    for _ in range(runs):
        with TemporaryDirectory() as folder:
            for found in (cold, warm):
                with started(Path(folder)) as (took, _pid):
                    found.append(took)
    for name, found, ready_s in (("cold", cold, 8.0), ("warm", warm, 4.0)):
        yield Row(
            what=f"serve to /healthz, {name}",
            unit="s",
            values=[r.healthz_s for r in found],
            target=2,
            before="25-92",
        )
        yield Row(
            what=f"serve to /readyz, {name}",
            unit="s",
            values=[r.readyz_s for r in found],
            target=ready_s,
            before="25-92",
        )
        yield Row(
            what=f"serve to /readyz, {name}", unit="CPU-s", values=[r.cpu_s for r in found], before="21"
        )


def idle(runs: int) -> Iterator[Row]:
    """A service with its world, after its start, without clients."""
    memory, processes, shares = [], [], []
    with TemporaryDirectory() as cache:
        for _ in range(runs):
            with started(Path(cache)) as (_start, pid):
                time.sleep(SETTLE_S)
                before_s, begun_s = tree_cpu_s(pid), time.perf_counter()
                time.sleep(IDLE_S)
                shares.append(100 * (tree_cpu_s(pid) - before_s) / (time.perf_counter() - begun_s))
                tree = [one.pid for one in tree_of(pid)]
                memory.append(pss_mb(tree))
                processes.append(float(len(tree)))
    yield Row(
        what="idle service with its world, memory (PSS)", unit="MB", values=memory, target=400, before="725"
    )
    yield Row(what="idle service with its world", unit="processes", values=processes, before="6")
    yield Row(what="idle service with its world", unit="% of a core", values=shares, target=3, before="3-8")


def goals(runs: int) -> Iterator[Row]:
    """Goals to their plans, and missions to their ends with robots that are done at once."""
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    for name, server, before in (("SQLite", None, ("13.6", "1.5")), ("PostgreSQL", SERVER, ("2.2", "0.6"))):
        found = []
        for _ in range(runs):
            if server is None:
                found.append(throughput.figures(None, worker, ROUNDS))
            else:
                with database_on(server) as url:
                    found.append(throughput.figures(url, worker, ROUNDS))
        proposed, to_the_end = before
        for what, values, target, was in (
            ("goals proposed", [one.planned for one in found], 20.0, proposed),
            ("missions to their end", [one.finished for one in found], 10.0, to_the_end),
            ("missions to their end, none waiting for another", [one.apart for one in found], 10.0, ""),
        ):
            yield Row(
                what=f"{what}, {name}",
                unit="a second",
                values=[one.a_second for one in values],
                target=target,
                before=was,
                more_is_better=True,
            )
    worker.close()


def posts(runs: int) -> Iterator[Row]:
    """POST /v1/goals at 50 a second."""
    for name, server in (("SQLite", None), ("PostgreSQL", SERVER)):
        found = []
        for _ in range(runs):
            with service_on(server) as served:
                found.append(post(served, a_second=A_SECOND, seconds=POSTED_S))
        yield Row(
            what=f"POST /v1/goals, 50 a second, p99, {name}",
            unit="ms",
            values=[r.p99_ms for r in found],
            target=150,
        )
        yield Row(
            what=f"POST /v1/goals, 50 a second, {name}", unit="CPU-ms", values=[r.cpu_ms for r in found]
        )


def read(runs: int) -> Iterator[Row]:
    """Reads beside bare FastAPI."""
    for one in reads.compare(runs):
        ratios = [ours / bare for ours, bare in zip(one.ours, one.bare, strict=True)]
        yield Row(
            what=f"GET {one.path} beside bare FastAPI",
            unit="ratio",
            values=ratios,
            target=0.5,
            more_is_better=True,
        )
