"""Our uses of uvicorn's private names. Each name has a contract test of this module.

`uvicorn.Config(http=…)` takes a protocol class, and there is no other way to limit the time of a request's header and
body: uvicorn itself waits for both for ever.
"""

import asyncio

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from app.api.connections import Connections, Peer
from app.api.problem_body import raw_problem

TOO_LATE = raw_problem(408, "request-too-slow", "send it faster")


def bounded_http(connections: Connections) -> type[H11Protocol]:
    """uvicorn's HTTP protocol with time limits; reports to `connections` whether a request is under way.

    Needs H11Protocol's `conn` (the h11 connection), `transport`, `loop`, `on_response_complete` and
    `handle_websocket_upgrade`, that it is constructed for each connection, and WebSocketsSansIOProtocol's
    `handshake_initiated`. Without them half-sent requests would keep their connections for ever.
    """
    limits = connections.limits

    class BoundedHttp(H11Protocol):
        _peer: Peer
        _deadline: asyncio.TimerHandle | None = None
        _timed: object = None
        """The part of the request that the deadline is for, as h11 names the client's state."""
        _has_sent = False

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            self._peer = transport.get_extra_info("peername")
            self._look()

        def data_received(self, data: bytes) -> None:
            self._has_sent = True
            super().data_received(data)
            self._look()

        def on_response_complete(self) -> None:
            super().on_response_complete()
            self._has_sent = False
            self._look()

        def handle_websocket_upgrade(self, event: h11.Request) -> None:
            self._time(None)
            connections.serve(self._peer)
            super().handle_websocket_upgrade(event)
            # A header that h11 accepts and websockets does not would leave the connection open for ever.
            if not getattr(self.transport.get_protocol(), "handshake_initiated", False):
                self.transport.abort()

        def connection_lost(self, exc: Exception | None) -> None:
            self._time(None)
            super().connection_lost(exc)

        def _look(self) -> None:
            """Update deadline and connection count by h11's states of the request and the response."""
            if self.transport.is_closing() or self.transport.get_protocol() is not self:
                return
            theirs = self.conn.their_state
            self._time(theirs if theirs in (h11.IDLE, h11.SEND_BODY) else None)
            if self.conn.our_state in (h11.SEND_RESPONSE, h11.SEND_BODY):
                connections.serve(self._peer)
            else:
                connections.wait(self._peer, self.transport.abort)

        def _time(self, part: object) -> None:
            """Set the deadline for a part of the request, unless it is set already."""
            if part is self._timed:
                return
            if self._deadline is not None:
                self._deadline.cancel()
                self._deadline = None
            self._timed = part
            if part is not None:
                limit_s = limits.header_timeout_s if part is h11.IDLE else limits.body_timeout_s
                self._deadline = self.loop.call_later(limit_s, self._end_late)

        def _end_late(self) -> None:
            if self._has_sent and self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
                self.transport.write(TOO_LATE)
                self.transport.close()
            else:
                self.transport.abort()

    return BoundedHttp
