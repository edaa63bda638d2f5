"""Hearing what other processes have written to a shared database: PostgreSQL's LISTEN and NOTIFY.

A notification only says that it is worth looking; whoever looks reads the record. So nothing is lost with one that
never comes, and after the connection was away everything is looked at once.
"""

import logging
import math
import time
from collections.abc import Callable, Mapping

import psycopg

from app.store.engine import CHANNEL, WRITTEN, Database
from app.workflows.background import Background

LOOK_S = 0.5
"""How long the thread waits before it looks whether it is to end."""
BACK_OFF_S = 1.0
SETTLED_S = 5.0
"""So long after it, whoever else lost a connection has it back, too; then everything is looked at once more."""

logger = logging.getLogger(__name__)


class Listening:
    """A thread that tells this process what others have announced; on SQLite there are no others."""

    def __init__(self, database: Database, topics: Mapping[str, Callable[[], None]]) -> None:
        """:param topics: what is called when something of a topic was announced, besides `Database.committed`."""
        self._database = database
        self._topics: Mapping[str, Callable[[], None]] = {WRITTEN: self._written, **topics}
        self._background = Background("listening", self._run)

    def start(self) -> None:
        if self._database.shared:
            self._background.start()

    def close(self) -> None:
        self._background.end()

    def _run(self) -> None:
        while not self._background.ending.is_set():
            try:
                self._listen()
            except psycopg.Error as error:
                logger.warning("not told of what other processes write: %s", str(error).strip())
                self._background.ending.wait(BACK_OFF_S)

    def _listen(self) -> None:
        # A connection of its own, not the pool's: it waits all the time.
        given, options = self._database.engine.dialect.create_connect_args(self._database.engine.url)
        with psycopg.connect(*given, **options, autocommit=True, connect_timeout=5) as connection:
            connection.execute(f"LISTEN {CHANNEL}")
            self._look_at_all()
            settled_at = time.monotonic() + SETTLED_S
            while not self._background.ending.is_set():
                if time.monotonic() >= settled_at:
                    self._look_at_all()
                    settled_at = math.inf
                for notification in connection.notifies(timeout=LOOK_S):
                    topic, _, writer = notification.payload.partition(" ")
                    if writer != self._database.name:  # its own writes are told without this detour
                        self._heard(topic)

    def _look_at_all(self) -> None:
        for topic in self._topics:
            self._heard(topic)

    def _heard(self, topic: str) -> None:
        try:
            self._topics.get(topic, lambda: None)()
        except Exception:
            logger.exception("what another process announced (%s) could not be followed", topic)

    def _written(self) -> None:
        for call in self._database.committed:
            call()
