"""The HTTP server of `macta serve`, in a thread of its own.

It listens from the start. Until the API is built, it answers `/healthz` and refuses all other requests with 503.
"""

import threading
from types import TracebackType
from typing import Self

import uvicorn
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from app.api.connections import BoundedListener
from app.api.problem_body import PROBLEM, problem_body
from app.api.uvicorn_private import bounded_http

GRACE_S = 3
"""How long open event streams may delay the shutdown."""
STARTED_S = 0.02
RETRY_AFTER_S = 2


class HttpServer:
    """Serves within a `with` block; `serve` sets the application."""

    def __init__(self, listener: BoundedListener) -> None:
        """:param listener: bound; the server listens on it."""
        self.port: int = listener.getsockname()[1]
        self._app: ASGIApp = _starting
        config = uvicorn.Config(
            self._answer,
            interface="asgi3",
            http=bounded_http(listener.connections),
            loop="asyncio",  # another event loop would not call the listener's accept
            log_level="warning",
            access_log=False,
            lifespan="off",
            timeout_graceful_shutdown=GRACE_S,
            ws_max_size=64 * 2**20,
        )
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run, args=([listener],), name="http", daemon=True)

    @property
    def is_alive(self) -> bool:
        return self._thread.is_alive()

    def serve(self, app: ASGIApp) -> None:
        """Pass requests to the application from now on."""
        self._app = app

    def stop(self) -> None:
        """End the open requests, streams within `GRACE_S`; safe to call again."""
        self._server.should_exit = True
        self._thread.join()

    def __enter__(self) -> Self:
        self._thread.start()
        while not self._server.started and self._thread.is_alive():
            self._thread.join(STARTED_S)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        await self._app(scope, receive, send)


async def _starting(scope: Scope, receive: Receive, send: Send) -> None:
    """The application until the API is built."""
    if scope["type"] != "http":
        await send({"type": "websocket.close", "code": 1013})
        return
    if scope["path"] == "/healthz":
        answer = JSONResponse({"status": "alive"})
    else:
        detail = "the service is starting: its worlds and its record are not ready yet"
        answer = JSONResponse(problem_body(503, "starting", detail), 503, media_type=PROBLEM)
    answer.headers.update(
        {"cache-control": "no-store", "x-content-type-options": "nosniff", "retry-after": str(RETRY_AFTER_S)}
    )
    await answer(scope, receive, send)
