"""`macta robot embody`: moves a robot's mind into another body on a running service, or says which body it is in."""

import time
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from app.cli.service_calls import answer_of
from app.domain.errors import Invalid
from app.domain.lifecycles.embodiment import OPEN

if TYPE_CHECKING:
    from httpx2 import Client

ASKED_S = 0.25


def embody(
    service: "Client", robot: str, body: str | None, *, lease_s: float | None = None, patience_s: float = 60.0
) -> str:
    """Move the robot's mind, and wait for the move's end; says which body it is in then.

    :param body: its kind; None: only say which body it is in now.
    :raises Invalid: if the service refuses, with its reason, or the mind does not get the body.
    """
    path = f"/v1/robots/{quote(robot, safe='')}"
    if body is None:
        if lease_s is not None:
            raise Invalid("name the body that has this lease")
        return _words(answer_of(service, "GET", f"{path}/embodiment"))
    moved = answer_of(service, "POST", f"{path}:embody", {"body": body, "lease_s": lease_s})
    until_s = time.monotonic() + patience_s
    while _newest(moved).get("state") in OPEN:
        if time.monotonic() > until_s:
            raise Invalid(
                f"the move is {_newest(moved)['state']}; macta robot embody {robot} says how it goes on"
            )
        time.sleep(ASKED_S)
        moved = answer_of(service, "GET", f"{path}/embodiment")
    now = "real" if moved["kind"] == "real" else moved["body"]["kind"]
    if now != body:
        raise Invalid(f"{_words(moved)}: {_newest(moved).get('reason') or 'it was moved again meanwhile'}")
    if lease_s is not None and moved["lease_s"] != lease_s:
        raise Invalid(
            f"{_words(moved)}: the lease is not in force, {_newest(moved).get('reason') or 'try again'}"
        )
    return _words(moved)


def _newest(embodiment: dict[str, Any]) -> dict[str, Any]:
    attempts: list[dict[str, Any]] = embodiment["attempts"]
    return attempts[0] if attempts else {}


def _words(embodiment: dict[str, Any]) -> str:
    words = f"{embodiment['robot']} is in a {embodiment['kind']} body"
    if embodiment["kind"] != "real":
        words += f", {embodiment['body']['kind']}"
    if embodiment["lease_until_s"] is not None:
        words += (
            f", until {embodiment['lease_until_s']:.0f} s of its world's time unless the service renews it"
        )
    move = _newest(embodiment)
    return (
        f"{words}; a move to {move['body']['kind']} is {move['state']}"
        if move.get("state") in OPEN
        else words
    )
