"""One thread that serves any number of MQTT clients: with a thread each, a fleet's would contend for the GIL."""

import logging
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from robots.link.mqtt.session import Session

CHECK_INTERVAL_S = 0.5
"""Between two checks of keep-alives and lost connections, at most."""
FIRST_PAUSE_S = 0.1
LONGEST_PAUSE_S = 5.0
"""Back-off between attempts to reach the broker; all clients wait until one of them is connected."""
FLUSH_TIMEOUT_S = 2.0

logger = logging.getLogger(__name__)


class Reactor:
    """Connects the sessions and reconnects lost ones. `start` before use, `close` at the end."""

    def __init__(
        self, sessions: Sequence[Session], *, broker: str, wall_s: Callable[[], float] = time.monotonic
    ):
        """:param broker: its address, for the log."""
        self._sessions = list(sessions)
        self._broker = broker
        self._wall_s = wall_s
        self._selector = selectors.DefaultSelector()
        self._waiting: deque[Session] = deque()
        self._awake = False
        self._stop = False
        self._wake_reader, self._wake_writer = socket.socketpair()
        self._wake_reader.setblocking(False)
        self._wake_writer.setblocking(False)
        self._selector.register(self._wake_reader, selectors.EVENT_READ)
        self._pause_s = FIRST_PAUSE_S
        self._next_attempt_s = 0.0
        self._complaint = ""
        self._logged = ""
        """The reason of the failure that was logged last; empty once a client is connected."""
        self.refused = False
        """True if the broker is reachable but refuses a client."""
        self._thread = threading.Thread(target=self._run, name="mqtt", daemon=True)
        self._has_new = False
        for session in self._sessions:
            self._adopt(session)

    def _adopt(self, session: Session) -> None:
        session.wake = self._wake
        session.client.user_data_set(session)
        session.client.on_socket_open = self._opened
        session.client.on_socket_close = self._closed

    def add(self, session: Session) -> None:
        """Serve another session, from any thread."""
        self._adopt(session)
        self._sessions = [*self._sessions, session]
        self._has_new = True
        self._wake(None)

    def remove(self, session: Session) -> None:
        """Send what is queued for a session, and disconnect it; from any thread."""
        session.retired = True
        session.disconnecting = True
        session.client.disconnect()
        self._wake(session)

    @property
    def complaint(self) -> str:
        """Why a client is not connected, in words; empty if no failure is known."""
        return self._complaint

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Send what is queued, at most for `FLUSH_TIMEOUT_S`, and disconnect. Idempotent."""
        self._stop = True
        self._wake(None)
        if self._thread.ident is None:
            self._release()  # it was never started, so nothing is queued
        elif self._thread.is_alive():
            self._thread.join()
        for session in self._sessions:
            session.connected = False

    def _wake(self, session: Session | None) -> None:
        if session is not None:
            self._waiting.append(session)
        if not self._awake:
            self._awake = True
            with suppress(OSError):  # full: it will wake; closed: the thread has ended
                self._wake_writer.send(b"\0")

    def _run(self) -> None:
        check_s = 0.0
        while not self._stop:
            self._poll(CHECK_INTERVAL_S)
            if self._wall_s() >= check_s or self._has_new:
                self._has_new = False
                check_s = self._wall_s() + CHECK_INTERVAL_S
                self._connect()
                for session in self._sessions:
                    session.client.loop_misc()
                    self._write(session)
        self._disconnect_all()
        self._release()

    def _release(self) -> None:
        self._selector.close()
        self._wake_reader.close()
        self._wake_writer.close()

    def _poll(self, timeout_s: float) -> None:
        """Wait for sockets and queued messages, then read and write."""
        for key, events in self._selector.select(timeout_s):
            if key.data is None:
                with suppress(BlockingIOError):
                    self._wake_reader.recv(4096)
            else:
                self._serve(key.data, events)
        self._awake = False  # before the queue is emptied: who queues now wakes the thread again
        while self._waiting:
            self._write(self._waiting.popleft())

    def _serve(self, session: Session, events: int) -> None:
        client = session.client
        if events & selectors.EVENT_READ:
            client.loop_read()
            # NOTE: bytes in our buffer or in TLS's do not make the socket readable again.
            while (sock := client.socket()) is not None and (
                client.has_more or getattr(sock, "pending", int)()
            ):
                client.loop_read()
        if events & selectors.EVENT_WRITE or client.want_write():
            self._write(session)
        if session.connected:
            self._pause_s = FIRST_PAUSE_S
            self._complaint = self._logged = ""
            self.refused = False

    def _write(self, session: Session) -> None:
        client = session.client
        client.loop_write()
        sock = client.socket()
        if sock is not None:
            wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if client.want_write() else 0)
            if self._selector.get_key(sock).events != wanted:
                self._selector.modify(sock, wanted, session)

    def _connect(self) -> None:
        """Reconnect the lost sessions in turn until one fails; the pause doubles with each failure."""
        for session in self._sessions:
            if session.client.socket() is not None or session.retired:
                continue
            if session.refused:
                self._note_failure(f"does not let {session.name} in: {session.refused}", session.refused)
                session.refused = ""
                self.refused = True
            if session.closed_early:
                self._note_failure(
                    f"closed the connection before accepting {session.name}; does it need TLS or a client certificate?",
                    "closed early",
                )
                session.closed_early = False
            if self._wall_s() < self._next_attempt_s or self._stop:
                return
            session.before_connecting()
            try:
                session.client.reconnect()
            except (OSError, ValueError) as error:
                self._note_failure(f"cannot be reached: {error}", str(error))

    def _note_failure(self, why: str, reason: str) -> None:
        """:param reason: logged once, however many sessions it keeps from connecting."""
        if reason != self._logged:
            logger.warning("broker %s %s", self._broker, why)
        self._logged = reason
        self._complaint = why
        self._next_attempt_s = self._wall_s() + self._pause_s
        self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)

    def _disconnect_all(self) -> None:
        give_up_s = self._wall_s() + FLUSH_TIMEOUT_S
        while self._wall_s() < give_up_s and any(
            session.connected and session.client.want_write() for session in self._sessions
        ):
            self._poll(0.05)
        for session in self._sessions:
            session.disconnecting = True
            session.client.disconnect()
            self._write(session)

    def _opened(self, client: Any, session: Session, sock: Any) -> None:
        self._selector.register(sock, selectors.EVENT_READ, session)

    def _closed(self, client: Any, session: Session, sock: Any) -> None:
        with suppress(KeyError, ValueError):
            self._selector.unregister(sock)
