"""Requests generated from the API's schema, valid and invalid: how many are answered with 500.

    uv run python -m benchmarks.request_fuzz [REQUESTS] [SERVER]

On SQLite and on a database of the server, with robots that take no time. Prints the count of answers by status, and
what schemathesis finds: undeclared answers, accepted invalid requests, rejected valid ones.
"""

import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import schemathesis
from fastapi import FastAPI
from schemathesis.config import SchemathesisConfig
from schemathesis.engine import events, from_schema

from app.api.openapi import TOKEN_SCHEME
from app.composition import RunningWorld, Service
from app.settings import Settings
from benchmarks.databases import SERVER, database_on
from benchmarks.throughput import Instant
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.world import load_world

TOKEN = "a-token-of-the-benchmark"
EXAMPLES = 40
"""Requests of each operation and phase in a round."""
ACCEPTED = ["2xx", "404", "409", "412", "422", "429", "503", "504"]
"""Allowed answers to a request that fits the schema, which may still name no place or contradict the world."""


@dataclass(slots=True, kw_only=True)
class Fuzzed:
    """The answers by status, and what is wrong with them: check and operation, with an example each."""

    statuses: Counter[int] = field(default_factory=Counter)
    findings: dict[str, str] = field(default_factory=dict)

    @property
    def requests(self) -> int:
        return sum(self.statuses.values())


def fuzz(
    api: FastAPI,
    token: str,
    *,
    examples: int,
    seed: int,
    stateful: bool = True,
    paths: Sequence[str] = (),
    into: Fuzzed | None = None,
) -> Fuzzed:
    """One round of requests to every operation of the API, in this process. Its event streams must end by themselves.

    :param examples: requests of each operation and phase, beside those that cover the schema's limits.
    :param stateful: make requests that follow from each other's answers, too.
    :param paths: those to ask for; none: all.
    :param into: what earlier rounds found.
    """
    fuzzed = into or Fuzzed()
    config = SchemathesisConfig.from_dict(
        {
            "seed": seed,
            "auth": {"openapi": {TOKEN_SCHEME: {"bearer": token}}},
            "generation": {"max-examples": examples},
            "phases": {"stateful": {"enabled": stateful}},
            "checks": {"positive_data_acceptance": {"expected-statuses": ACCEPTED}},
        }
    )
    schema = schemathesis.openapi.from_asgi(
        "/openapi.json", api, config=config, headers={"authorization": f"Bearer {token}"}
    )
    if paths:
        schema = schema.include(path=list(paths))
    for event in from_schema(schema).execute():
        if isinstance(event, events.ScenarioFinished):
            _count(event, fuzzed)
        elif isinstance(event, events.NonFatalError):
            fuzzed.findings.setdefault(f"{event.label}: error", str(event.info))
        elif isinstance(event, events.FatalError):
            raise event.exception
    return fuzzed


def _count(event: events.ScenarioFinished, fuzzed: Fuzzed) -> None:
    for interaction in event.recorder.interactions.values():
        if interaction.response is not None:
            fuzzed.statuses[interaction.response.status_code] += 1
    for checks in event.recorder.checks.values():
        for check in checks:
            if check.failure_info is not None:
                failure = check.failure_info.failure
                name = f"{event.label}: {check.name}: {failure.title}"
                fuzzed.findings.setdefault(name, f"{failure.message}\n{check.failure_info.code_sample}")


@contextmanager
def _service(database_url: str | None) -> Iterator[Service]:
    near, far = InMemoryLink.pair()
    file = load_world("sample_store")
    clock = ManualClock()
    world = RunningWorld(file=file, link=near, clock=clock, rate=None, run="benchmark")
    with tempfile.TemporaryDirectory() as folder, Instant(far, clock):
        settings = Settings(data=Path(folder), token=TOKEN, database_url=database_url)
        with Service(settings, [world]) as service:
            service.planner_ready.result()
            service.stopping.set()  # streams end after the present state
            yield service


def _run(name: str, database_url: str | None, requests: int) -> None:
    fuzzed = Fuzzed()
    seed = 0
    with _service(database_url) as service:
        while fuzzed.requests < requests:
            fuzz(service.api, TOKEN, examples=EXAMPLES, seed=seed, into=fuzzed)
            seed += 1
            print(f"{name}, after round {seed}: {fuzzed.requests} requests", flush=True)
    counts = ", ".join(f"{status}: {count}" for status, count in sorted(fuzzed.statuses.items()))
    print(f"{name}: {fuzzed.requests} requests, {fuzzed.statuses[500]} answers of 500 ({counts})", flush=True)
    for finding, example in fuzzed.findings.items():
        print(f"  {finding}\n    {example}", flush=True)


def main(requests: int = 20_000, server: str = SERVER) -> None:
    _run("SQLite", None, requests)
    with database_on(server) as url:
        _run("PostgreSQL", url, requests)


if __name__ == "__main__":
    main(*(convert(given) for convert, given in zip((int, str), sys.argv[1:], strict=False)))
