"""Reads of the API beside bare FastAPI: `python -m benchmarks.reads`.

`macta serve` with a record of copied missions answers each request; so does a FastAPI application of its own under
uvicorn, whose endpoints return the same objects, made beforehand, with the same response models. One connection each,
in turn. Prints requests a second of the server's CPU time, which is what it can answer on one core, medians.
"""

import argparse
import http.client
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import urlsplit

from benchmarks.growth.record import SMALL, fill
from benchmarks.growth.requests import Record, approve, submit, wait
from benchmarks.processes import cpu_s
from tests.scenarios.serving import macta_serve

SERVE = "--serve"
REQUESTS = 60
ROUNDS = 5
IDLE_S = 1.0
"""How long what a process does besides is measured, each time; it is not counted."""
READS = (
    ("/v1/goals", "Page[GoalBody]"),
    ("/v1/goals/{goal_id}", "GoalBody"),
    ("/v1/plans?limit=10", "Page[PlanBody]"),
    ("/v1/plans/{plan_id}", "PlanBody"),
    ("/v1/missions?limit=20", "Page[MissionBody]"),
    ("/v1/missions/{mission_id}", "MissionBody"),
    ("/v1/robots", "Page[RobotBody]"),
    ("/v1/worlds/{world_id}/facts", "FactsBody"),
)
"""Paths, and the models of their answers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """Requests a second of CPU time, one for each round."""

    path: str
    ours: list[float]
    bare: list[float]

    @property
    def ratio(self) -> float:
        return median(self.ours) / median(self.bare)


def serve_bare(payloads: dict[str, Any]) -> None:
    """Serve objects made of the payloads with FastAPI and uvicorn alone; prints the port."""
    import socket

    import uvicorn
    from fastapi import FastAPI

    from app.api import bodies, mission_bodies
    from app.domain import plan_document

    names = vars(bodies) | vars(mission_bodies) | vars(plan_document)
    bare = FastAPI()
    for number, (path, model) in enumerate(READS):
        kind = eval(model, names)
        bare.get(f"/{number}", response_model=kind)(_returns(kind.model_validate(payloads[path])))
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    print(listener.getsockname()[1], flush=True)
    uvicorn.Server(uvicorn.Config(bare, log_level="warning", access_log=False, http="h11")).run([listener])


def _returns(answer: Any) -> Callable[[], Any]:
    def read() -> Any:
        return answer

    return read


@contextmanager
def bare_server(payloads: dict[str, Any]) -> Iterator[tuple[int, int]]:
    """The port and the process id of a server of the payloads."""
    command = [sys.executable, "-m", "benchmarks.reads", SERVE]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        server.stdin.write(json.dumps(payloads))
        server.stdin.close()
        yield int(server.stdout.readline()), server.pid
        server.terminate()


def requests_a_cpu_s(netloc: str, path: str, pid: int, token: str) -> float:
    """How many of these requests the process answers in a second of its CPU time."""
    client = http.client.HTTPConnection(netloc, timeout=60)
    idle_from_s, idle_s = time.perf_counter(), cpu_s(pid)
    time.sleep(IDLE_S)
    idle_share = (cpu_s(pid) - idle_s) / (time.perf_counter() - idle_from_s)
    begun_s = before_s = 0.0
    for number in range(REQUESTS + 1):
        if number == 1:  # the first one opens the connection
            begun_s, before_s = time.perf_counter(), cpu_s(pid)
        client.request("GET", path, headers={"authorization": f"Bearer {token}"})
        answer = client.getresponse()
        answer.read()
        if answer.status != 200:
            raise RuntimeError(f"{path}: {answer.status}")
    used_s = cpu_s(pid) - before_s - idle_share * (time.perf_counter() - begun_s)
    client.close()
    return REQUESTS / used_s


def compare(rounds: int = ROUNDS) -> Iterator[Compared]:
    with (
        TemporaryDirectory() as folder,
        macta_serve(Path(folder), "--speed", "5") as served,
        served.client() as api,
    ):
        record = Record(api=api, names={"world": "sample_store"}, carried_out="")
        goal = submit(record, "move sample_1 to bay_7")
        wait(record, f"/v1/goals/{goal}", "planned")
        mission = approve(record, goal)
        wait(record, f"/v1/goals/{goal}", "finished")
        fill(f"sqlite:///{Path(folder) / 'macta.sqlite'}", SMALL)
        names = Record.of(api, SMALL, mission).names
        paths = {path: path.format(**names) for path, _ in READS}
        payloads = {path: api.get(filled).raise_for_status().json() for path, filled in paths.items()}
        netloc = urlsplit(served.address).netloc
        with bare_server(payloads) as (port, pid):
            for number, (path, _) in enumerate(READS):
                ours, bare = [], []
                for _ in range(rounds):
                    ours.append(requests_a_cpu_s(netloc, paths[path], served.process.pid, served.token))
                    bare.append(requests_a_cpu_s(f"127.0.0.1:{port}", f"/{number}", pid, ""))
                yield Compared(path=path, ours=ours, bare=bare)


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--rounds", type=int, default=ROUNDS)
    for one in compare(options.parse_args().rounds):
        print(
            f"{one.path:32s} {median(one.ours):6.0f} ({min(one.ours):.0f} to {max(one.ours):.0f}),"
            f" bare {median(one.bare):6.0f} ({min(one.bare):.0f} to {max(one.bare):.0f}): {one.ratio:.2f}",
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:] == [SERVE]:
        serve_bare(json.load(sys.stdin))
    else:
        main()
