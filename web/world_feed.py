"""Follows one world through the service's public API, and goes on after the service was away.

A thread reads the telemetry stream, another asks for the facts; `latest()` hands out what is known, complete
and never half changed.
"""

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import httpx2
from pydantic import TypeAdapter, ValidationError

from web.api_types import Fact, Layout, Telemetry

FACTS = TypeAdapter(tuple[Fact, ...])


@dataclass(frozen=True, slots=True, kw_only=True)
class Known:
    """What the view knows of the world; `version` grows with every change."""

    version: int = 0
    live: bool = False
    title: str = ""
    layout: Layout | None = None
    facts: tuple[Fact, ...] = ()
    telemetry: Telemetry = field(default_factory=Telemetry)


class WorldFeed:
    """One world's layout, facts and telemetry, kept fresh until `stop`."""

    def __init__(
        self, *, api: str, token: str, world: str, facts_every_s: float = 1.0, again_s: float = 1.0
    ) -> None:
        self._world = world
        self._facts_every_s, self._again_s = facts_every_s, again_s
        # The service may be quiet for a while between two lines, never for as long as this.
        timeout = httpx2.Timeout(10.0, read=30.0)
        headers = {"authorization": f"Bearer {token}"}
        self._client = httpx2.Client(base_url=api, headers=headers, timeout=timeout, trust_env=False)
        self._known = Known()
        self._changed = threading.Condition()
        self._stopped = threading.Event()
        self._threads = [
            threading.Thread(target=self._repeat, args=(work,), daemon=True)
            for work in (self._follow_telemetry, self._ask_facts)
        ]
        self._running = len(self._threads)

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End soon: with the next word at the latest, without waiting for it."""
        self._stopped.set()
        with self._changed:
            self._changed.notify_all()

    def latest(self, after: int = -1, timeout_s: float = 0.0) -> Known:
        """What is known, waiting up to `timeout_s` for something newer than version `after`."""
        with self._changed:
            self._changed.wait_for(lambda: self._known.version > after or self._stopped.is_set(), timeout_s)
            return self._known

    def _repeat(self, work: Callable[[], None]) -> None:
        while not self._stopped.is_set():
            try:
                work()
            except (httpx2.HTTPError, ValidationError, ValueError, KeyError):
                self._learn(live=False)
            self._stopped.wait(self._again_s)
        with self._changed:
            self._running -= 1
            is_last = self._running == 0
        if is_last:  # closed under another thread, a connection that is just being made would stay open
            self._client.close()

    def _follow_telemetry(self) -> None:
        body = self._get(f"/v1/worlds/{self._world}")
        self._learn(layout=Layout.model_validate(body["layout"]), title=str(body.get("title") or self._world))
        for data in self._lines(f"/v1/telemetry?world={self._world}"):
            self._learn(telemetry=Telemetry.model_validate_json(data), live=True)
            if self._stopped.is_set():
                return

    def _ask_facts(self) -> None:
        while not self._stopped.is_set():
            body = self._get(f"/v1/worlds/{self._world}/facts")
            self._learn(facts=FACTS.validate_python(body["items"]))
            self._stopped.wait(self._facts_every_s)

    def _get(self, path: str) -> dict[str, object]:
        answer = self._client.get(path)
        answer.raise_for_status()
        body: dict[str, object] = answer.json()
        return body

    def _lines(self, path: str) -> Iterator[str]:
        with self._client.stream("GET", path) as answer:
            answer.raise_for_status()
            for line in answer.iter_lines():
                if line.startswith("data:"):
                    yield line.removeprefix("data:").strip()

    def _learn(self, **changes: object) -> None:
        with self._changed:
            new = replace(self._known, **changes)  # type: ignore[arg-type]
            if new != self._known:
                self._known = replace(new, version=self._known.version + 1)
                self._changed.notify_all()
