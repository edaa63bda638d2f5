"""The authenticated relay of `/viewer/` to the viser server, which listens on loopback only.

HTTP and WebSocket messages pass unchanged, with two exceptions: pages of another origin cannot open the socket, and
viser's request for a public share tunnel is dropped.
"""

import asyncio
from collections.abc import Callable
from typing import Annotated

import httpx2
import msgspec
from fastapi import APIRouter, Path, Request, Response, WebSocket
from pydantic import BaseModel
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocketDisconnect, WebSocketState
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.typing import Subprotocol

from app.api.auth import own_origin
from app.api.problems import problem
from app.api.streams import OpenCount

Upstream = Callable[[], str | None]
"""The viser server's address, `http://USER:SECRET@127.0.0.1:PORT`, or None while there is none. Asking may start it."""
Authenticate = Callable[[HTTPConnection], bool]


ViewId = Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{8,64}$")]
"""The id that a page and its embedded 3D view share."""


class ViewBody(BaseModel):
    running: bool


SHARE_REQUESTS = frozenset({"ShareUrlRequest", "ShareUrlDisconnect"})
"""viser's message types that open and close its public tunnel."""
PASSED_ON = ("content-type", "content-encoding", "cache-control", "etag")
MAX_FRAME_BYTES = 64 * 2**20
CONNECT_TIMEOUT_S = 5.0
POLICY_VIOLATION = 1008
TRY_AGAIN_LATER = 1013
# viser's page is one file with inline scripts and a WebAssembly worker; it must not call other hosts.
CONTENT_POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "connect-src 'self' blob: data:; frame-ancestors 'self'"
)


def view_router(upstream: Upstream) -> APIRouter:
    """The route that tells a page whether the 3D view is running."""
    router = APIRouter(prefix="/v1", tags=["health"])

    @router.get("/view")
    async def view() -> ViewBody:
        """Whether the 3D view at `/viewer/` accepts connections. The first request starts it."""
        return ViewBody(running=await _listens(upstream()))

    return router


async def _listens(address: str | None) -> bool:
    """True if the address accepts connections; a process that has just started does not yet."""
    if address is None:
        return False
    at = httpx2.URL(address)
    try:
        async with asyncio.timeout(CONNECT_TIMEOUT_S):
            _, writer = await asyncio.open_connection(at.host, at.port)
    except (OSError, TimeoutError):
        return False
    writer.close()
    return True


def viewer_router(upstream: Upstream, authenticate: Authenticate, *, max_open: int) -> APIRouter:
    """Routes that relay `/viewer/*` for clients that `authenticate` admits; `max_open` limits the sockets."""
    router = APIRouter(include_in_schema=False)
    open_ = OpenCount()

    @router.get("/viewer/{view}/")
    async def page_of(request: Request, view: ViewId) -> Response:
        return await page(request)

    @router.get("/viewer")
    @router.get("/viewer/{path:path}")
    async def page(request: Request, path: str = "") -> Response:
        if not authenticate(request):
            return problem(401, "token-needed", "the view of the world needs a token")
        if request.url.path == "/viewer":
            return Response(status_code=307, headers={"location": "viewer/"})
        address = upstream()
        if address is None:
            return problem(503, "view-unavailable", "the view of the world is not running")
        return await _fetch(f"{address}/{path}", request.headers.get("accept-encoding", "identity"))

    # The page opens its socket at its own address without the last slash, so the path identifies the page.
    @router.websocket("/viewer/{view}")
    async def socket_of(browser: WebSocket, view: ViewId) -> None:
        await socket(browser, view)

    @router.websocket("/viewer")
    @router.websocket("/viewer/")
    async def socket(browser: WebSocket, view: str = "") -> None:
        if not authenticate(browser) or not own_origin(browser):
            await browser.close(POLICY_VIOLATION)
            return
        address = upstream()
        if address is None or open_.count >= max_open:
            await browser.close(TRY_AGAIN_LATER)
            return
        with open_:
            await _relay(browser, f"{address}/{view}")

    return router


def is_share_request(frame: bytes) -> bool:
    """True for a frame that asks viser for its public tunnel, and for one that cannot be read at all."""
    try:
        message = msgspec.msgpack.decode(frame)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return True
    return not isinstance(message, dict) or message.get("type") in SHARE_REQUESTS


async def _fetch(url: str, accept_encoding: str) -> Response:
    try:
        # The server is on loopback: no proxy from the environment, and no certificates, which take 20 ms to read.
        async with (
            httpx2.AsyncClient(trust_env=False, verify=False, timeout=CONNECT_TIMEOUT_S) as client,
            client.stream("GET", url, headers={"accept-encoding": accept_encoding}) as answer,
        ):
            content = b"".join([chunk async for chunk in answer.aiter_raw()])
    except httpx2.HTTPError:
        return problem(503, "view-unavailable", "the view of the world does not answer")
    headers = {name: answer.headers[name] for name in PASSED_ON if name in answer.headers}
    headers |= {"content-security-policy": CONTENT_POLICY, "x-content-type-options": "nosniff"}
    return Response(content, status_code=answer.status_code, headers=headers)


async def _relay(browser: WebSocket, address: str) -> None:
    asked = [Subprotocol(name) for name in browser.scope.get("subprotocols", [])]
    try:
        viser = await connect(
            address.replace("http", "ws", 1),
            subprotocols=asked or None,
            compression=None,
            max_size=MAX_FRAME_BYTES,
            open_timeout=CONNECT_TIMEOUT_S,
            proxy=None,
        )
    except (OSError, WebSocketException):
        await browser.close(TRY_AGAIN_LATER)
        return
    async with viser:
        await browser.accept(subprotocol=viser.subprotocol)
        directions = {
            asyncio.create_task(_upwards(browser, viser)),
            asyncio.create_task(_downwards(viser, browser)),
        }
        try:
            done, _ = await asyncio.wait(directions, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in directions:
                task.cancel()
            await asyncio.gather(*directions, return_exceptions=True)
        for task in done:
            task.result()


async def _upwards(browser: WebSocket, viser: ClientConnection) -> None:
    """From the browser; text frames, which viser does not use, are dropped like the share requests."""
    while True:
        message = await browser.receive()
        if message["type"] == "websocket.disconnect":
            return
        frame = message.get("bytes")
        if frame is None or is_share_request(frame):
            continue
        try:
            await viser.send(frame)
        except ConnectionClosed:
            return


async def _downwards(viser: ClientConnection, browser: WebSocket) -> None:
    try:
        async for frame in viser:
            await browser.send_bytes(frame if isinstance(frame, bytes) else frame.encode())
    except ConnectionClosed:
        pass
    except (WebSocketDisconnect, RuntimeError):
        return  # the browser left in the middle of a frame
    if browser.application_state is WebSocketState.CONNECTED:
        # 1002 tells the page that its version differs from the server's, so it must be passed on.
        code = viser.close_code if viser.close_code in (1000, 1001, 1002) else 1011
        await browser.close(code, viser.close_reason or "")
