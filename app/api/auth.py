"""Authentication: only the health routes are reachable without the token.

A program sends `Authorization: Bearer TOKEN`; a browser gets a session cookie by opening `/?token=TOKEN` once.
"""

import hmac
from hashlib import sha256
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection, Request
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.api.problems import problem

COOKIE = "macta_session"
OPEN_PATHS = frozenset({"/healthz", "/readyz"})
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
SECURITY_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "content-security-policy": (
        "default-src 'self'; frame-ancestors 'self'; base-uri 'none'; object-src 'none'; form-action 'self'"
    ),
}


class TokenCheck:
    """Checks the token or session cookie of a connection."""

    def __init__(self, token: str) -> None:
        self._token = token.encode()
        self._session = hmac.new(self._token, b"macta console session", sha256).hexdigest()

    def admits(self, connection: HTTPConnection) -> bool:
        scheme, _, shown = connection.headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer" and self.opens(shown.strip()):
            return True
        session = connection.cookies.get(COOKIE, "")
        return hmac.compare_digest(session.encode(), self._session.encode()) and own_origin(connection)

    def opens(self, token: str) -> bool:
        return hmac.compare_digest(token.encode(), self._token)

    def open_console(self) -> Response:
        """The answer to `/?token=…`: a session cookie, and the address without the token."""
        answer = RedirectResponse("/", status_code=303)
        answer.set_cookie(COOKIE, self._session, httponly=True, samesite="strict", max_age=30 * 24 * 3600)
        return answer


class TokenMiddleware:
    """ASGI middleware that refuses connections that the token check does not admit, on every path."""

    def __init__(self, app: ASGIApp, check: TokenCheck) -> None:
        self._app = app
        self._check = check

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        if scope["type"] == "http":
            send = _with_security_headers(send)
        if scope["path"] in OPEN_PATHS or self._check.admits(connection):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": "a token is needed"})
        else:
            await self._refuse(Request(scope))(scope, receive, send)

    def _refuse(self, request: Request) -> Response:
        token = request.query_params.get("token")
        if (
            request.url.path == "/"
            and request.method == "GET"
            and token is not None
            and self._check.opens(token)
        ):
            return self._check.open_console()
        answer = problem(
            401,
            "token-needed",
            "send 'Authorization: Bearer TOKEN', or open the console at the address that macta serve printed",
        )
        answer.headers["www-authenticate"] = "Bearer"
        return answer


def own_origin(connection: HTTPConnection) -> bool:
    """True if the request is safe or of our own origin: the cookie must not let another site act for the operator."""
    if connection.scope["type"] == "http" and connection.scope["method"] in SAFE_METHODS:
        return True
    origin = connection.headers.get("origin")
    return origin is None or urlsplit(origin).netloc == connection.headers.get("host")


def _with_security_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return sending
