"""Judges orders to a robot that has a key: the service's, unchanged, and each taken once, over restarts of both.

The service's counters are its clock's nanoseconds, so several services may order one robot, with clocks a little apart:
an order is taken if its counter is new and at most `WINDOW_S` less than the greatest. The robot needs no clock. A
counter somewhat ahead is stored as used up before orders up to it are taken, so that few of them cost a write; after
a restart what lies below is refused, and the service, which repeats what matters, gets through `RESERVED_S` later at
the latest.
"""

import heapq
import json
import logging
from typing import Protocol

from robots.link.mqtt.session import Publication
from robots.link.mqtt.signature import fault_of, key_id_of

WINDOW_S = 60.0
"""How far an order's counter may be behind the greatest: clocks of services that share a world may differ so much."""
RESERVED_S = 5.0
"""How far ahead counters are stored as used up; one write in this time at most."""
MAX_KEPT = 10_000
"""Counters kept of the window; with more, it gets shorter."""
NS = 1_000_000_000

logger = logging.getLogger(__name__)


class CounterStore(Protocol):
    """Keeps one text over restarts, as `robots.contract.memory_file.MemoryFile` does."""

    def load(self) -> str | None: ...

    def save(self, text: str) -> None: ...


class OrderCheck:
    """Of one robot. To be called from one thread."""

    def __init__(self, key: str, store: CounterStore | None = None) -> None:
        """
        :param store: None: the robot that is restarted takes orders that were recorded before.
        :raises OSError: if the store cannot be read.
        :raises ValueError: if what it holds is no record of counters.
        """
        self._key = key
        self._store = store
        self._key_id = key_id_of(key)
        self._reserved = self._stored()
        self._floor = self._reserved
        self._greatest = self._floor
        self._taken: set[int] = set()
        self._ascending: list[int] = []
        """The same counters, as a heap."""

    def doubt(self, publication: Publication) -> str:
        """Why it is not an order of the service that is to be carried out; empty if it is."""
        if reason := fault_of(publication, self._key):
            return reason
        counter = int(publication.counter)
        if counter <= self._floor or counter in self._taken:
            return "an earlier message was sent again"
        self._taken.add(counter)
        heapq.heappush(self._ascending, counter)
        self._greatest = max(self._greatest, counter)
        self._floor = max(self._floor, self._greatest - round(WINDOW_S * NS))
        while self._ascending[0] <= self._floor or len(self._ascending) > MAX_KEPT:
            passed = heapq.heappop(self._ascending)
            self._taken.discard(passed)
            self._floor = max(self._floor, passed)
        if counter > self._reserved:
            self._reserve(counter + round(RESERVED_S * NS))
        return ""

    def _stored(self) -> int:
        """The counter up to which all are used up. Those of another key say nothing of this one."""
        text = None if self._store is None else self._store.load()
        if text is None:
            return -1
        try:
            record = json.loads(text)
            return int(record["used_up"]) if record["key"] == self._key_id else -1
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f"{self._store} holds no record of counters ({error!r}); enrol the robot with a new key and remove it"
            ) from error

    def _reserve(self, counter: int) -> None:
        self._reserved = counter
        if self._store is None:
            return
        try:
            self._store.save(json.dumps({"key": self._key_id, "used_up": counter}))
        except OSError as error:
            # An order to stop must get through to a robot whose disk is full.
            logger.error("%s: orders could be sent again after a restart: %s", self._store, error)
