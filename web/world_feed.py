"""Follows one world through the service's public API, and reconnects after the service was unavailable.

One thread reads the telemetry stream, another polls the facts.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

import httpx2
from pydantic import TypeAdapter, ValidationError

from web.api_types import Fact, Layout, Telemetry

FACTS = TypeAdapter(tuple[Fact, ...])
CONNECT_TIMEOUT_S = 10.0
READ_TIMEOUT_S = 30.0
"""The service is never silent for longer between two lines of a stream."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSnapshot:
    """What is known of the world."""

    layout: Layout | None = None
    facts: tuple[Fact, ...] = ()
    telemetry: Telemetry = field(default_factory=Telemetry)


class WorldFeed:
    """One world's layout, facts and telemetry, updated until `stop`."""

    def __init__(
        self, *, api: str, token: str, world: str, facts_every_s: float = 1.0, retry_s: float = 1.0
    ) -> None:
        self._world = world
        self._facts_every_s = facts_every_s
        self._retry_s = retry_s
        self._client = httpx2.Client(
            base_url=api,
            headers={"authorization": f"Bearer {token}"},
            timeout=httpx2.Timeout(CONNECT_TIMEOUT_S, read=READ_TIMEOUT_S),
            trust_env=False,
        )
        self.latest = WorldSnapshot()
        """The newest snapshot; the same object as long as nothing changes."""
        self._edition: object = None
        """Of the layout."""
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._threads = [
            threading.Thread(target=self._repeat, args=(work,), daemon=True)
            for work in (self._follow_telemetry, self._poll_facts)
        ]
        self._running = len(self._threads)

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End at the next message at the latest; does not wait for it."""
        self._stopped.set()

    def _repeat(self, work: Callable[[], None]) -> None:
        while not self._stopped.is_set():
            with suppress(httpx2.HTTPError, ValidationError, ValueError, KeyError):
                work()
            self._stopped.wait(self._retry_s)
        with self._lock:
            self._running -= 1
            is_last = self._running == 0
        if is_last:  # closing it before would leak a connection that the other thread opens
            self._client.close()

    def _follow_telemetry(self) -> None:
        self._read_layout()
        for data in self._stream(f"/v1/telemetry?world={self._world}"):
            self._update(telemetry=Telemetry.model_validate_json(data))
            if self._stopped.is_set():
                return

    def _poll_facts(self) -> None:
        while not self._stopped.is_set():
            body = self._get(f"/v1/worlds/{self._world}/facts")
            if body["edition"] != self._edition:
                self._read_layout()
            self._update(facts=FACTS.validate_python(body["items"]))
            self._stopped.wait(self._facts_every_s)

    def _read_layout(self) -> None:
        known = self._get(f"/v1/worlds/{self._world}")
        self._edition = known["edition"]
        self._update(layout=Layout.model_validate(known["layout"]))

    def _get(self, path: str) -> dict[str, object]:
        response = self._client.get(path)
        response.raise_for_status()
        body: dict[str, object] = response.json()
        return body

    def _stream(self, path: str) -> Iterator[str]:
        with self._client.stream("GET", path) as response:
            response.raise_for_status()
            for line in response.iter_lines():
                if line.startswith("data:"):
                    yield line.removeprefix("data:").strip()

    def _update(self, **changes: object) -> None:
        with self._lock:
            new = replace(self.latest, **changes)  # type: ignore[arg-type]
            if new != self.latest:
                self.latest = new
