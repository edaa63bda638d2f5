"""Problem bodies (RFC 9457), also for responses sent before the API exists or without it."""

import json
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

PROBLEM = "application/problem+json"


def problem_body(
    status: int, code: str, detail: str, choices: Sequence[str] = (), **more: Any
) -> dict[str, Any]:
    """A problem body: `type` is a stable code, `detail` names the thing, `choices` what would work."""
    body: dict[str, Any] = {
        "type": f"urn:macta:problem:{code}",
        "title": code.replace("-", " ").capitalize(),
        "status": status,
        "detail": detail,
        **more,
    }
    if choices:
        body["choices"] = list(choices)
    return body


def raw_problem(status: int, code: str, detail: str, **headers: str) -> bytes:
    """A whole HTTP/1.1 response for a connection that is closed after it.

    :param headers: further ones; an underscore stands for a hyphen.
    """
    body = json.dumps(problem_body(status, code, detail)).encode()
    lines = {"content-type": PROBLEM, "connection": "close", "content-length": str(len(body))}
    lines |= {name.replace("_", "-"): value for name, value in headers.items()}
    head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
    return f"HTTP/1.1 {status} {HTTPStatus(status).phrase}\r\n{head}\r\n".encode() + body
