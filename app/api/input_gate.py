"""Middleware that checks each request's size and characters before a route handles it.

It refuses, and names, characters that are invisible or disguise text: control characters (PostgreSQL cannot store NUL,
a line feed forges a line of the log), lone surrogates, direction marks and zero-width characters.
"""

import json
import re
import unicodedata
from collections.abc import Iterator
from typing import Any
from urllib.parse import parse_qsl, unquote_to_bytes, urlsplit

from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.api.problems import Misfit, malformed, problem

MAX_BODY_BYTES = 1_000_000
INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Unicode categories: controls, formats (zero-width, direction), surrogates, line and paragraph separators."""
LINE_BREAKS = "\t\n\r"
"""Control characters that are allowed in a body's text."""
SINGLE_LINE_HEADERS = ("host", "origin", "if-match", "idempotency-key", "last-event-id")
"""Headers that the service reads; they must be printable ASCII."""
URL_PREFIXES = {"host": "//", "origin": ""}
"""Headers that name a host, and the prefix that makes a URL of their value."""
_UNUSUAL = re.compile(rb"[^\t\n\r\x20-\x7e]|\\u")


class _TooLarge(Exception):
    """Raised when a body is larger than `MAX_BODY_BYTES`."""


class InputGate:
    """ASGI middleware that refuses requests whose body is too large or whose text holds refused characters."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        misfits = [*_of_target(scope), *_of_headers(Headers(scope=scope))]
        if scope["type"] == "websocket":
            if misfits:
                await send({"type": "websocket.close", "code": 1008, "reason": misfits[0][1][:120]})
            else:
                await self._app(scope, receive, send)
            return
        try:
            body = b"" if misfits else await _body(scope, receive)
        except ClientDisconnect:
            return
        except _TooLarge:
            detail = f"the body is larger than {MAX_BODY_BYTES} bytes"
            await problem(413, "too-large", detail)(scope, receive, send)
            return
        if misfits := misfits or list(_of_body(body)):
            await malformed(misfits)(scope, receive, send)
        else:
            await self._app(scope, _replayed(body, receive), send)


def refused_character(text: str, allowed: str = "") -> str | None:
    """What is wrong with the text, naming the first refused character and its place; None if nothing is."""
    for position, character in enumerate(text, start=1):
        if unicodedata.category(character) in INVISIBLE and character not in allowed:
            code = ord(character)
            if 0xDC80 <= code <= 0xDCFF:
                return f"byte {code - 0xDC00:#04x} at character {position} is not UTF-8"
            name = unicodedata.name(character, _NAMES.get(character, "surrogate"))
            return f"character {position} is U+{code:04X} ({name.lower()}), which is not accepted"
    return None


_NAMES = {chr(code): "control character" for code in (*range(0x20), *range(0x7F, 0xA0))} | {"\0": "NUL"}


def _of_target(scope: Scope) -> Iterator[Misfit]:
    """Misfits of the path and the query."""
    raw_path = scope.get("raw_path") or scope["path"].encode()
    path = unquote_to_bytes(raw_path).decode(errors="surrogateescape")
    if wrong := refused_character(path):
        yield "path", wrong
    for name, value in parse_qsl(
        scope["query_string"].decode("latin-1"), keep_blank_values=True, errors="surrogateescape"
    ):
        if wrong := refused_character(name):
            yield "query", wrong
        elif wrong := refused_character(value):
            yield f"query.{name}", wrong


def _of_headers(headers: Headers) -> Iterator[Misfit]:
    for name in SINGLE_LINE_HEADERS:
        value = headers.get(name, "")
        if not (value.isascii() and value.isprintable()):
            yield f"header.{name}", "only printable ASCII characters are accepted"
        elif name in URL_PREFIXES and _is_malformed(URL_PREFIXES[name] + value):
            yield f"header.{name}", f"{value!r} is not a valid host and port"


def _is_malformed(url: str) -> bool:
    try:
        _ = urlsplit(url).port
    except ValueError:
        return True
    return False


async def _body(scope: Scope, receive: Receive) -> bytes:
    """The whole body.

    :raises _TooLarge: before it is read, if its length is declared.
    """
    declared = Headers(scope=scope).get("content-length", "")
    if declared.isdecimal() and (len(declared) > 18 or int(declared) > MAX_BODY_BYTES):
        raise _TooLarge
    body = bytearray()
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ClientDisconnect
        body += message.get("body", b"")
        if len(body) > MAX_BODY_BYTES:
            raise _TooLarge
        if not message.get("more_body", False):
            return bytes(body)


def _of_body(body: bytes) -> Iterator[Misfit]:
    """Misfits of the strings and keys of a JSON body; one that is not JSON is left to the routes."""
    if _UNUSUAL.search(body) is None:
        return
    try:
        document = json.loads(body)
    except (ValueError, RecursionError):
        return
    yield from refused_in(document)


def refused_in(document: Any) -> Iterator[Misfit]:
    """Misfits of the strings and keys of a document of JSON's types."""
    pending: list[tuple[str, Any]] = [("body", document)]
    while pending:
        slot, value = pending.pop()
        if isinstance(value, dict):
            for key, child in value.items():
                if wrong := refused_character(key):
                    yield slot, f"in a key, {wrong}"
                else:
                    pending.append((f"{slot}.{key}", child))
        elif isinstance(value, list):
            pending += [(f"{slot}.{index}", child) for index, child in enumerate(value)]
        elif isinstance(value, str) and (wrong := refused_character(value, LINE_BREAKS)):
            yield slot, wrong


def _replayed(body: bytes, receive: Receive) -> Receive:
    """A `receive` that returns the body already read, then the client's further messages, such as its disconnect."""
    is_read = False

    async def replay() -> Message:
        nonlocal is_read
        if is_read:
            return await receive()
        is_read = True
        return {"type": "http.request", "body": body, "more_body": False}

    return replay
