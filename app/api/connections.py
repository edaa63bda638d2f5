"""Limits on the API's open connections, applied before authentication.

asyncio accepts a whole backlog at once and logs a traceback for each connection that it has no descriptor for, so the
listening socket itself counts connections. At a limit, a connection that has sent no request for `GRACE_S` is closed in
favour of a new one; connections with a request under way are not closed.
"""

import errno
import logging
import os
import resource
import socket
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from app.api.problem_body import raw_problem
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Invalid
from app.settings import Settings

RESERVED_DESCRIPTORS = 192
"""File descriptors for the database's connections, recordings, child processes and the robots' link."""
FEWEST = 16
LOG_EVERY_S = 60.0
GRACE_S = 0.1
"""A new connection's time to send its request: in a flood it would otherwise be ended before its request is read."""
SEND_TIMEOUT_S = 60
"""The longest that a peer may leave sent data unacknowledged or its receive window closed."""
REFUSAL = raw_problem(503, "too-many-connections", "close some first", retry_after="5")

Peer = tuple[Any, ...]
"""A connection's far end, as `socket.accept` names it; the first part is the address."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionLimits:
    """Limits on open connections and on the time that a request may take to arrive.

    :param total: connections at a time.
    :param per_address: likewise, from one address.
    :param header_timeout_s: from the first to the last byte of a request's header; also until the first request.
    :param body_timeout_s: for a request's body, after the header.
    """

    total: int
    per_address: int
    header_timeout_s: float
    body_timeout_s: float

    @classmethod
    def of(cls, settings: Settings) -> "ConnectionLimits":
        """The settings' limits, fewer if the process may not open as many files.

        Each connection may need a second descriptor, to the 3D view.

        :raises Invalid: if fewer than `FEWEST` connections are left.
        """
        needed = RESERVED_DESCRIPTORS + settings.connections + settings.open_streams
        descriptors = _descriptors(needed)
        total = settings.connections
        if descriptors < needed:
            total = min(total, (descriptors - RESERVED_DESCRIPTORS) // 2)
        if total < min(FEWEST, settings.connections):
            least = RESERVED_DESCRIPTORS + 2 * FEWEST
            raise Invalid(
                f"this process may open {descriptors} files, {least} are needed: raise the limit, `ulimit -n {least}`"
            )
        if total < settings.connections:
            log.warning(
                "this process may open only %d files: at most %d connections are accepted, not MACTA_CONNECTIONS=%d",
                descriptors,
                total,
                settings.connections,
            )
        return cls(
            total=total,
            per_address=settings.connections_per_address,
            header_timeout_s=settings.header_timeout_s,
            body_timeout_s=settings.body_timeout_s,
        )


def _descriptors(needed: int) -> int:
    """Raise this process's limit of open files towards `needed`; returns the limit, or `needed` if it is higher."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY or soft >= needed:
        return needed
    soft = needed if hard == resource.RLIM_INFINITY else min(needed, hard)
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return soft


class Connections:
    """The open connections and which of them wait for a request; for the event loop's thread only."""

    def __init__(self, limits: ConnectionLimits, clock: WallClock = SYSTEM_CLOCK) -> None:
        self.limits = limits
        self._clock = clock
        self._open: dict[str, dict[Peer, AcceptedSocket]] = {}
        """By address."""
        self._waiting: dict[str, dict[Peer, tuple[float, Callable[[], None]]]] = {}
        """By address, the one that has waited longest first; since when, and what ends them."""
        self.count = 0

    def admit(self, accepted: "AcceptedSocket", peer: Peer) -> bool:
        """Count a new connection; False if it exceeds a limit and no waiting connection can be closed for it."""
        address = str(peer[0])
        if len(self._open.get(address, ())) >= self.limits.per_address:
            log.warning(
                "connections from %s are at their limit, %d (MACTA_CONNECTIONS_PER_ADDRESS)",
                address,
                self.limits.per_address,
            )
            if not self._end_waiting(address):
                return False
        if self.count >= self.limits.total:
            log.warning("connections are at their limit, %d (MACTA_CONNECTIONS)", self.limits.total)
            most = max(self._waiting, key=lambda one: len(self._waiting[one]), default="")
            if not self._end_waiting(most):
                return False
        self._open.setdefault(address, {})[peer] = accepted
        self.count += 1
        return True

    def wait(self, peer: Peer, end: Callable[[], None]) -> None:
        """Note that a connection waits for a request, or for the rest of one's header.

        :param end: drops the connection.
        """
        if peer in self._open.get(str(peer[0]), ()):
            self._waiting.setdefault(str(peer[0]), {}).setdefault(peer, (self._clock.monotonic_s(), end))

    def serve(self, peer: Peer) -> None:
        """Note that a connection has a request under way."""
        _discard(self._waiting, peer)

    def release(self, peer: Peer) -> None:
        """Note that a connection is closed."""
        _discard(self._waiting, peer)
        self.count -= _discard(self._open, peer)

    def _end_waiting(self, address: str) -> bool:
        """End the connection of the address that has waited longest; False if none has waited long enough."""
        waiting = self._waiting.get(address)
        if not waiting:
            return False
        peer, (since_s, end) = next(iter(waiting.items()))
        if self._clock.monotonic_s() - since_s < GRACE_S:
            return False
        accepted = self._open[address][peer]
        end()
        # At once: the event loop would free the descriptor only after it has accepted the whole backlog.
        accepted.close()
        return True


def _discard(by_address: dict[str, dict[Peer, Any]], peer: Peer) -> bool:
    """Remove the peer; True if it was there."""
    address = str(peer[0])
    peers = by_address.get(address, {})
    was_there = peers.pop(peer, None) is not None
    if was_there and not peers:
        del by_address[address]
    return was_there


class AcceptedSocket(socket.socket):
    """A connection that is no longer counted once it is closed."""

    def __init__(self, accepted: socket.socket, release: Callable[[], None]) -> None:
        super().__init__(accepted.family, accepted.type, accepted.proto, fileno=accepted.detach())
        self._release = release

    def close(self) -> None:
        super().close()
        release = self._release
        self._release = _do_nothing  # the next connection may have the same peer
        release()


def _do_nothing() -> None:
    pass


class BoundedListener(socket.socket):
    """A TCP socket that accepts connections within the limits."""

    def __init__(self, family: socket.AddressFamily, connections: Connections) -> None:
        super().__init__(family)
        self.connections = connections
        self._spare = os.open(os.devnull, os.O_RDONLY)
        self.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Accepted sockets inherit both. asyncio sets the first only on sockets that it creates; without it a response
        # body waits 40 ms for an acknowledgement.
        self.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, SEND_TIMEOUT_S * 1000)

    def accept(self) -> tuple[socket.socket, Peer]:
        """The next connection within the limits; others are refused with 503.

        :raises BlockingIOError: if the backlog is empty.
        """
        while True:
            try:
                accepted, peer = super().accept()
            except OSError as error:
                if error.errno not in (errno.EMFILE, errno.ENFILE):
                    raise
                self._refuse_one()
                continue
            connection = AcceptedSocket(accepted, partial(self.connections.release, peer))
            if self.connections.admit(connection, peer):
                return connection, peer
            _refuse(connection)

    def close(self) -> None:
        super().close()
        self._close_spare()

    def _refuse_one(self) -> None:
        """Accept one connection with the spare descriptor and refuse it; it would otherwise block the backlog.

        :raises BlockingIOError: if the backlog is empty, or another thread has taken the descriptor.
        """
        log.warning("connection refused: no file descriptor is left; raise the limit, `ulimit -n`")
        self._close_spare()
        try:
            accepted, _ = super().accept()
            _refuse(accepted)
        except OSError as error:
            raise BlockingIOError from error
        finally:
            with suppress(OSError):
                self._spare = os.open(os.devnull, os.O_RDONLY)

    def _close_spare(self) -> None:
        if self._spare >= 0:
            os.close(self._spare)
            self._spare = -1


def _refuse(connection: socket.socket) -> None:
    connection.setblocking(False)
    with suppress(OSError):  # the peer may have closed it
        connection.send(REFUSAL)
    connection.close()


class Throttle(logging.Filter):
    """Passes each warning of a logger once in `LOG_EVERY_S`, with the number of those suppressed in between."""

    def __init__(self, clock: WallClock = SYSTEM_CLOCK) -> None:
        super().__init__()
        self._clock = clock
        self._passed: dict[str, tuple[float, int]] = {}
        """By the message without its values: when one passed, and how many were suppressed since."""

    def filter(self, record: logging.LogRecord) -> bool:
        if record.levelno != logging.WARNING:
            return True
        now_s = self._clock.monotonic_s()
        last_s, kept = self._passed.get(record.msg, (-LOG_EVERY_S, 0))
        if now_s - last_s < LOG_EVERY_S:
            self._passed[record.msg] = (last_s, kept + 1)
            return False
        self._passed[record.msg] = (now_s, 0)
        if kept:
            record.msg = f"{record.msg}; {kept} more like it since the last line"
        return True


def throttle_warnings() -> None:
    """Throttle the warnings that clients without a token can cause: about connections and unreadable requests."""
    for name in (__name__, "uvicorn.error"):
        logging.getLogger(name).addFilter(Throttle())
