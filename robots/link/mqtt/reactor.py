"""One thread that serves any number of MQTT clients: a fleet's are many, and a thread each would fight for the GIL."""

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

LOOK_S = 0.5
"""At most this much passes between two looks at keep-alives and lost connections."""
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.1, 5.0
"""Back-off between attempts to reach the broker; all clients wait for one of them to get through."""
FAREWELL_S = 2.0

logger = logging.getLogger(__name__)


class Reactor:
    """Connects the sessions, and again whenever they are lost. `start` before use, `close` at the end."""

    def __init__(
        self, sessions: Sequence[Session], *, broker: str, wall_s: Callable[[], float] = time.monotonic
    ):
        """:param broker: its address, for the log."""
        self._sessions, self._broker, self._wall_s = list(sessions), broker, wall_s
        self._selector = selectors.DefaultSelector()
        self._waiting: deque[Session] = deque()
        self._awake, self._stop = False, False
        self._ear, self._mouth = socket.socketpair()
        self._ear.setblocking(False)
        self._mouth.setblocking(False)
        self._selector.register(self._ear, selectors.EVENT_READ)
        self._pause_s, self._next_s, self._complaint = FIRST_PAUSE_S, 0.0, ""
        self.refused = False
        """True if the broker is there but does not let a client in."""
        self._thread = threading.Thread(target=self._run, name="mqtt", daemon=True)
        for session in self._sessions:
            session.wake = self._wake
            session.client.user_data_set(session)
            session.client.on_socket_open, session.client.on_socket_close = self._opened, self._closed

    @property
    def complaint(self) -> str:
        """Why the broker cannot be entered now, in words; empty if nothing is known to be wrong."""
        return self._complaint

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Take leave of the broker: what is queued is sent first, as far as that goes quickly. Safe to call again."""
        self._stop = True
        self._wake(None)
        if self._thread.is_alive():
            self._thread.join()
        for session in self._sessions:
            session.connected = False

    def _wake(self, session: Session | None) -> None:
        if session is not None:
            self._waiting.append(session)
        if not self._awake:
            self._awake = True
            with suppress(OSError):  # full: it will wake; closed: it has ended
                self._mouth.send(b"\0")

    def _run(self) -> None:
        look_s = 0.0
        while not self._stop:
            self._turn(LOOK_S)
            if self._wall_s() >= look_s:
                look_s = self._wall_s() + LOOK_S
                self._connect()
                for session in self._sessions:
                    session.client.loop_misc()
                    self._write(session)
        self._take_leave()
        self._selector.close()
        self._ear.close()
        self._mouth.close()

    def _turn(self, timeout_s: float) -> None:
        """Wait for work and do it: read what has come, write what waits."""
        for key, events in self._selector.select(timeout_s):
            if key.data is None:
                with suppress(BlockingIOError):
                    self._ear.recv(4096)
            else:
                self._serve(key.data, events)
        self._awake = False  # before the queue is emptied: who queues something now wakes us again
        while self._waiting:
            self._write(self._waiting.popleft())

    def _serve(self, session: Session, events: int) -> None:
        client = session.client
        if events & selectors.EVENT_READ:
            client.loop_read()
            # NOTE: what is read already, or decrypted, does not make the socket readable again.
            while (sock := client.socket()) is not None and (
                client.has_more or getattr(sock, "pending", int)()
            ):
                client.loop_read()
        if events & selectors.EVENT_WRITE or client.want_write():
            self._write(session)
        if session.connected:
            self._pause_s, self._complaint, self.refused = FIRST_PAUSE_S, "", False

    def _write(self, session: Session) -> None:
        client = session.client
        client.loop_write()
        sock = client.socket()
        if sock is not None:
            wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if client.want_write() else 0)
            if self._selector.get_key(sock).events != wanted:
                self._selector.modify(sock, wanted, session)

    def _connect(self) -> None:
        """Try the lost sessions in turn until one fails; the next attempt is later, each time more so."""
        for session in self._sessions:
            if session.client.socket() is not None or session.retired:
                continue
            if session.refused:
                self._complain(f"does not let {session.name} in: {session.refused}")
                session.refused, self.refused = "", True
            if session.turned_away:
                self._complain(
                    f"closes before it lets {session.name} in; does it want TLS, or a certificate of ours?"
                )
                session.turned_away = False
            if self._wall_s() < self._next_s or self._stop:
                return
            try:
                session.client.reconnect()
            except (OSError, ValueError) as error:
                self._complain(f"cannot be reached: {error}")

    def _complain(self, why: str) -> None:
        if why != self._complaint:
            logger.warning("broker %s %s", self._broker, why)
        self._complaint = why
        self._next_s = self._wall_s() + self._pause_s
        self._pause_s = min(2 * self._pause_s, LONGEST_PAUSE_S)

    def _take_leave(self) -> None:
        give_up_s = self._wall_s() + FAREWELL_S
        while self._wall_s() < give_up_s and any(
            session.connected and session.client.want_write() for session in self._sessions
        ):
            self._turn(0.05)
        for session in self._sessions:
            session.leaving = True
            session.client.disconnect()
            self._write(session)

    def _opened(self, client: Any, session: Session, sock: Any) -> None:
        self._selector.register(sock, selectors.EVENT_READ, session)

    def _closed(self, client: Any, session: Session, sock: Any) -> None:
        with suppress(KeyError, ValueError):
            self._selector.unregister(sock)
