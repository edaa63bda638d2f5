"""Notifications of what other processes have written to a shared database: PostgreSQL's LISTEN and NOTIFY.

A notification only says that something has changed; its handler reads the tables. So a lost notification loses no data,
and after a reconnection every handler is called once.
"""

import logging
import math
from collections.abc import Callable, Mapping

import psycopg

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.store.engine import CHANNEL, WRITTEN, Database
from app.workflows.background import Background
from app.workflows.engine import WAKE

RECEIVE_S = 0.5
"""How long the thread waits for a notification before it checks whether it is to end."""
RECONNECT_S = 1.0
SETTLED_S = 5.0
"""After a reconnection, when every handler is called once more: the other processes have reconnected by then."""

logger = logging.getLogger(__name__)


class NotificationListener:
    """A thread that receives what other processes announce; on SQLite there are no others."""

    def __init__(
        self,
        database: Database,
        topics: Mapping[str, Callable[[], None]],
        *,
        wake: Callable[[str | None], None],
        clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """
        :param topics: handlers by topic, besides what is called after commits of the database.
        :param wake: wakes a workflow that runs here, by its id; with None all of them, after a reconnection.
        """
        self._database = database
        self._topics: Mapping[str, Callable[[], None]] = {WRITTEN: database.written_elsewhere, **topics}
        self._wake = wake
        self._clock = clock
        self._background = Background("notifications", self._run)

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
                logger.warning("listening for notifications failed: %s", str(error).strip())
                self._clock.wait(self._background.ending, RECONNECT_S)

    def _listen(self) -> None:
        # A connection of its own, not the pool's: it waits all the time.
        given, options = self._database.engine.dialect.create_connect_args(self._database.engine.url)
        with psycopg.connect(*given, **options, autocommit=True, connect_timeout=5) as connection:
            connection.execute(f"LISTEN {CHANNEL}")
            self._handle_all()
            settled_s = self._clock.monotonic_s() + SETTLED_S
            while not self._background.ending.is_set():
                if self._clock.monotonic_s() >= settled_s:
                    self._handle_all()
                    settled_s = math.inf
                for notification in connection.notifies(timeout=RECEIVE_S):
                    topic, _, writer = notification.payload.partition(" ")
                    if writer != self._database.name:  # its own writes are handled in `Database.write`
                        self._handle(topic)

    def _handle_all(self) -> None:
        for topic in (*self._topics, WAKE):
            self._handle(topic)

    def _handle(self, topic: str) -> None:
        name, _, subject = topic.partition(":")
        try:
            if name == WAKE:
                self._wake(subject or None)
            elif name in self._topics:
                self._topics[name]()
        except Exception:
            logger.exception("handling of a notification failed (topic %s)", topic)
