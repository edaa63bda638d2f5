"""Our uses of viser's private names. Each name has a contract test of this module."""

import hmac
import warnings
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

import viser
import websockets.asyncio.server
from viser import _messages
from websockets.asyncio.server import ServerConnection, basic_auth
from websockets.http11 import Request, Response


def guarded_server(
    *, port: int, secret: str, on_request: Callable[[], None] = lambda: None
) -> viser.ViserServer:
    """A viser server on loopback that answers only clients with the secret as password, and no other site's page.

    `on_request` is called, in the server's thread, for each request with the secret.

    viser itself checks no client, and any client can make it open a public tunnel. Needs that viser calls
    `websockets.asyncio.server.serve` by that name with `process_request`, and
    `ViserServer._websock_server.unregister_handler` with `viser._messages.ShareUrlRequest` and `ShareUrlDisconnect`.
    """
    serve = websockets.asyncio.server.serve
    has_secret = basic_auth(
        "Macta", check_credentials=lambda _, shown: hmac.compare_digest(shown.encode(), secret.encode())
    )

    def serve_guarded(*arguments: Any, process_request: Callable[..., Any], **options: Any) -> Any:
        async def guard(connection: ServerConnection, request: Request) -> Response | None:
            # The service's relay sends no Origin; every browser does when it opens a socket.
            if "Origin" in request.headers:
                return connection.respond(HTTPStatus.FORBIDDEN, "The view is opened through the service.\n")
            refusal = await has_secret(connection, request)
            if refusal is None:
                on_request()
            answer: Response | None = refusal or process_request(connection, request)
            return answer

        return serve(*arguments, process_request=guard, **options)

    websockets.asyncio.server.serve = serve_guarded  # type: ignore[assignment, misc]
    try:
        server = viser.ViserServer(host="127.0.0.1", port=port, label="Macta", verbose=False)
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(message)
    return server


def request_path(server: viser.ViserServer, client_id: int) -> str:
    """The path at which a browser opened its socket; empty once it has disconnected.

    Needs `ViserServer._websock_server._live_connections`: viser has no public way to ask for it. Without it no browser
    could be assigned to the page that embeds it, and every page would show the first world with nothing selected.
    """
    connection = server._websock_server._live_connections.get(client_id)
    return "" if connection is None or connection.request is None else connection.request.path


def move(handle: viser.SceneNodeHandle, position: tuple[float, float, float]) -> None:
    """Move a node: `handle.position = position` without viser's `numpy.allclose`, five times as fast.

    Needs `_impl` with `name`, `position` and `api._queue_scene_message`, and `viser._messages.SetPositionMessage`.
    """
    node = handle._impl
    if tuple(node.position) != position:
        node.position[:] = position
        node.api._queue_scene_message(_messages.SetPositionMessage(node.name, position))


def ignore_closed_connections() -> None:
    """Suppress viser's warnings of browsers that disconnect during drawing.

    Needs the text of viser's warning. Without it the log fills with warnings, and nothing else changes.
    """
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
