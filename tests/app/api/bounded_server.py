"""uvicorn behind a bounded listener, on an event loop whose time a test advances."""

import asyncio
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import uvicorn
from starlette.types import Receive, Scope, Send

from app.api.connections import BoundedListener, ConnectionLimits, Connections, Peer
from app.api.uvicorn_private import bounded_http
from tests.app.stepped_clock import SteppedClock
from tests.waiting import until

LIMITS = ConnectionLimits(total=50, per_address=50, header_timeout_s=10.0, body_timeout_s=60.0)
REQUEST = b"GET / HTTP/1.1\r\nhost: x\r\n\r\n"
STREAM = b"GET /stream HTTP/1.1\r\nhost: x\r\n\r\n"
LOOPBACK = "127.0.0.1"


class SteppedLoop(asyncio.SelectorEventLoop):
    """Its time runs, and can be set ahead."""

    ahead_s = 0.0

    def time(self) -> float:
        return super().time() + self.ahead_s


class WatchedConnections(Connections):
    """Counts how often a connection began to wait for a request: an accepted one does so a moment later."""

    waits = 0

    def wait(self, peer: Peer, end: Callable[[], None]) -> None:
        super().wait(peer, end)
        self.waits += 1


@dataclass
class BoundedServer:
    """Answers any request with its body's length, after reading it; `/stream` ends when `stream_ends` is set."""

    port: int
    connections: WatchedConnections
    clock: SteppedClock
    loop: SteppedLoop
    stream_ends: asyncio.Event

    def connect(self, sent: bytes = b"", source: str = LOOPBACK) -> socket.socket:
        """A client that has sent this and that the server knows of."""
        client = socket.create_connection((LOOPBACK, self.port), timeout=20, source_address=(source, 0))
        client.sendall(sent)
        return client

    def stream(self, source: str = LOOPBACK) -> socket.socket:
        """A client whose response has begun and goes on."""
        client = self.connect(STREAM, source)
        read_to(client, b"begun")
        return client

    def answer(self, source: str = LOOPBACK) -> bytes:
        """The answer to a new client; whatever was sent before has reached the server by then."""
        with self.connect(REQUEST.replace(b"host", b"connection: close\r\nhost"), source) as client:
            return rest(client)

    def advance(self, step_s: float) -> None:
        def step() -> None:
            self.loop.ahead_s += step_s
            self.clock.advance(step_s)

        self.loop.call_soon_threadsafe(step)

    def end_streams(self) -> None:
        self.loop.call_soon_threadsafe(self.stream_ends.set)


def read_to(client: socket.socket, end: bytes) -> bytes:
    """What the client receives up to this and with it."""
    got = b""
    while end not in got:
        more = client.recv(65536)
        assert more, f"the connection was closed after {got!r}"
        got += more
    return got


LAST_CHUNK = b"0\r\n\r\n"
"""Of a chunked response, as all of the server are."""


def rest(client: socket.socket) -> bytes:
    """Whatever the client still receives until its connection is closed."""
    got = b""
    try:
        while more := client.recv(65536):
            got += more
    except ConnectionResetError:
        pass
    return got


@contextmanager
def bounded(**limits: float) -> Iterator[BoundedServer]:
    """Serve for the length of the block; other limits than `LIMITS` by name."""
    clock = SteppedClock()
    connections = WatchedConnections(replace(LIMITS, **limits), clock)  # type: ignore[arg-type]
    ends = asyncio.Event()

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.accept"})
            while (message := await receive())["type"] == "websocket.receive":
                await send({"type": "websocket.send", "text": message["text"]})
            return
        body = b""
        await send_start(send) if scope["path"] == "/stream" else None
        while True:
            message = await receive()
            body += message.get("body", b"")
            if not message.get("more_body"):
                break
        if scope["path"] == "/stream":
            await ends.wait()
            await send({"type": "http.response.body", "body": b"ended"})
            return
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": str(len(body)).encode()})

    with BoundedListener(socket.AF_INET, connections) as listener:
        listener.bind((LOOPBACK, 0))
        config = uvicorn.Config(app, http=bounded_http(connections), log_level="error", lifespan="off")
        server = uvicorn.Server(config)
        loop = SteppedLoop()
        thread = threading.Thread(target=_run, args=[loop, server, listener])
        thread.start()
        until(lambda: server.started)
        running = BoundedServer(listener.getsockname()[1], connections, clock, loop, ends)
        try:
            yield running
        finally:
            running.end_streams()
            server.should_exit = True
            thread.join(20)


def _run(loop: SteppedLoop, server: uvicorn.Server, listener: socket.socket) -> None:
    with asyncio.Runner(loop_factory=lambda: loop) as runner:
        runner.run(server.serve([listener]))


async def send_start(send: Send) -> None:
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"begun", "more_body": True})
