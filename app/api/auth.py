"""Authentication: only the health routes are reachable without the token.

A program sends `Authorization: Bearer TOKEN`; a browser gets a session cookie by opening `/?token=TOKEN` once. The
session ends when it has not been used for `SESSION_S`.
"""

import hmac
import re
from hashlib import sha256
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection, Request
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.api.problems import problem
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.settings import MIN_TOKEN_LENGTH

SESSION_S = 12 * 3600
OPEN_PATHS = frozenset({"/healthz", "/readyz"})
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
SECURITY_HEADERS = {
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "content-security-policy": (
        "default-src 'self'; img-src 'self' data:; frame-ancestors 'self'; base-uri 'none'; object-src 'none'; "
        "form-action 'self'"
    ),
}


API_PREFIX = "/v1/"


class TokenCheck:
    """Checks the token or session cookie of a connection."""

    def __init__(self, token: str, clock: WallClock = SYSTEM_CLOCK) -> None:
        if len(token) < MIN_TOKEN_LENGTH:
            raise ValueError(f"the token has {len(token)} characters, at least {MIN_TOKEN_LENGTH} are needed")
        self._token = token.encode()
        self._clock = clock

    def admits(self, connection: HTTPConnection) -> bool:
        scheme, _, shown = connection.headers.get("authorization", "").partition(" ")
        if scheme.lower() == "bearer" and self.opens(shown.strip()):
            return True
        return self._session_left_s(connection) > 0 and own_origin(connection)

    def opens(self, token: str) -> bool:
        return hmac.compare_digest(token.encode(), self._token)

    def open_console(self, connection: HTTPConnection) -> Response:
        """The answer to `/?token=…`: a session cookie, and the address without the token."""
        answer = RedirectResponse("/", status_code=303)
        answer.set_cookie(
            cookie_name(connection),
            self._session(str(int(self._clock.epoch_s()) + SESSION_S)),
            httponly=True,
            secure=_is_encrypted(connection),
            samesite="strict",
            max_age=SESSION_S,
        )
        return answer

    def renewed_cookie(self, connection: HTTPConnection) -> str | None:
        """A `Set-Cookie` that prolongs the connection's session, once half of its time has passed."""
        if 0 < self._session_left_s(connection) < SESSION_S / 2:
            return self.open_console(connection).headers["set-cookie"]
        return None

    def _session(self, ends: str) -> str:
        """A session's cookie.

        :param ends: epoch seconds.
        """
        sealed = f"macta console session until {ends}".encode()
        return f"{ends}.{hmac.new(self._token, sealed, sha256).hexdigest()}"

    def _session_left_s(self, connection: HTTPConnection) -> float:
        """Seconds to the end of the connection's session; 0 without one."""
        session = connection.cookies.get(cookie_name(connection), "")
        ends = session.partition(".")[0]
        if not hmac.compare_digest(session.encode(), self._session(ends).encode()):
            return 0.0
        return max(0.0, int(ends) - self._clock.epoch_s())


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
            send = _with_security_headers(send, scope["path"], cookie=self._check.renewed_cookie(connection))
        if scope["path"] in OPEN_PATHS or self._check.admits(connection):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": "a token is needed"})
        else:
            await self._refuse(Request(scope))(scope, receive, send)

    def _refuse(self, request: Request) -> Response:
        token = request.query_params.get("token")
        if (
            request.scope["path"] == "/"
            and request.method == "GET"
            and token is not None
            and self._check.opens(token)
        ):
            return self._check.open_console(request)
        answer = problem(
            401,
            "token-needed",
            "send 'Authorization: Bearer TOKEN', or open the console at the address that macta serve printed",
        )
        answer.headers["www-authenticate"] = "Bearer"
        return answer


def cookie_name(connection: HTTPConnection) -> str:
    """The session cookie's name, with the port, because browsers send a host's cookies to all its ports."""
    port = re.search(r":([0-9]{1,5})$", connection.headers.get("host", ""))
    return f"macta_session_{port[1] if port else 443 if _is_encrypted(connection) else 80}"


def _is_encrypted(connection: HTTPConnection) -> bool:
    return connection.scope["scheme"] in ("https", "wss")


def own_origin(connection: HTTPConnection) -> bool:
    """True if the request is safe or of our own origin, so that another site cannot use the operator's cookie."""
    if connection.scope["type"] == "http" and connection.scope["method"] in SAFE_METHODS:
        return True
    origin = connection.headers.get("origin")
    try:
        return origin is None or urlsplit(origin).netloc == connection.headers.get("host")
    except ValueError:
        return False


def _with_security_headers(send: Send, path: str, *, cookie: str | None) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
            if path.startswith(API_PREFIX):  # what the API answers is not to be left on an operator's disk
                headers.setdefault("cache-control", "no-store")
            if cookie is not None:
                headers.append("set-cookie", cookie)
        await send(message)

    return sending
