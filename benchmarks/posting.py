"""How long POST /v1/goals takes at a fixed pace: `python -m benchmarks.posting [sqlite] [postgresql]`.

`macta serve` gets goals at instants fixed beforehand, whether or not it has answered the ones before; each goal is
planned meanwhile. A latency counts from the goal's instant to the answer, so that waiting for the service counts too.
"""

import argparse
import http.client
import json
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory
from urllib.parse import urlsplit

from benchmarks.databases import SERVER, database_on
from benchmarks.processes import cpu_s
from tests.scenarios.serving import Served, macta_serve

CONNECTIONS = 32
SAMPLES = 4
FREE_BAYS = (1, 3, 4, 6, 7, 8, 9, 10, 12)
"""Bays without a sample at the start."""
TOKEN = "a-token-of-the-benchmark"


@dataclass(frozen=True, slots=True, kw_only=True)
class Posted:
    """Milliseconds of each request, and the CPU time of the service's process for each."""

    latencies_ms: Sequence[float]
    cpu_ms: float

    @property
    def p99_ms(self) -> float:
        return quantiles(self.latencies_ms, n=100)[-1]

    def __str__(self) -> str:
        return (
            f"{len(self.latencies_ms)} goals: median {median(self.latencies_ms):.0f} ms, p99 {self.p99_ms:.0f},"
            f" longest {max(self.latencies_ms):.0f}; {self.cpu_ms:.1f} CPU-ms of the service each"
        )


@contextmanager
def service_on(server: str | None) -> Iterator[Served]:
    """`macta serve` on SQLite or on a database of the server."""
    with TemporaryDirectory() as folder, database_on(server) if server else nullcontext() as url:
        variables = {"token": TOKEN} | ({"database_url": url} if url else {})
        with macta_serve(Path(folder), **variables) as served:
            yield served


def post(served: Served, *, a_second: float, seconds: float) -> Posted:
    """State goals at that pace.

    :raises RuntimeError: if one is not accepted.
    """
    local = threading.local()
    begin_s = time.perf_counter() + 0.5

    def state(number: int) -> float:
        due_s = begin_s + number / a_second
        time.sleep(max(0.0, due_s - time.perf_counter()))
        if not hasattr(local, "client"):
            local.client = http.client.HTTPConnection(urlsplit(served.address).netloc, timeout=120)
        text = f"move sample_{number % SAMPLES + 1} to bay_{FREE_BAYS[number % len(FREE_BAYS)]}"
        headers = {"authorization": f"Bearer {served.token}", "content-type": "application/json"}
        local.client.request("POST", "/v1/goals", json.dumps({"text": text}), headers)
        answer = local.client.getresponse()
        said = answer.read()
        if answer.status != http.HTTPStatus.ACCEPTED:
            raise RuntimeError(f"{text}: {answer.status} {said.decode()}")
        return 1000 * (time.perf_counter() - due_s)

    before_s = cpu_s(served.process.pid)
    with ThreadPoolExecutor(CONNECTIONS) as threads:
        took_ms = list(threads.map(state, range(int(a_second * seconds))))
    used_s = cpu_s(served.process.pid) - before_s
    return Posted(latencies_ms=took_ms, cpu_ms=1000 * used_s / len(took_ms))


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("databases", nargs="*", default=["sqlite", "postgresql"])
    options.add_argument("--a-second", type=float, default=50.0)
    options.add_argument("--seconds", type=float, default=30.0)
    given = options.parse_args()
    for database in given.databases:
        with service_on(SERVER if database == "postgresql" else None) as served:
            print(f"{database}: {post(served, a_second=given.a_second, seconds=given.seconds)}", flush=True)


if __name__ == "__main__":
    main()
