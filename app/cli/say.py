"""`macta robot say`: a person's word to one robot, on a running service."""

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from app.cli.service_calls import answer_of
from app.domain.lifecycles.dialogue import UNDER_WAY

if TYPE_CHECKING:
    from httpx2 import Client

POLL_S = 0.5


def say(
    service: "Client",
    robot: str,
    text: str,
    *,
    approve: bool,
    dialogue: str | None = None,
    patience_s: float,
    pause: Callable[[float], None] = time.sleep,
) -> Iterator[str]:
    """Say something; yields what the robot says until it has ended, asks, or waits for approval.

    :param patience_s: how long its end is awaited.
    :raises Invalid: if the service refuses, with its reason.
    """
    path = f"/v1/robots/{quote(robot, safe='')}/dialogues"
    word = {"text": text, "approve": approve, "dialogue": dialogue}
    known = answer_of(service, "POST", path, word)
    shown = len(known["lines"])
    yield from _lines(known, robot, len(known["lines"]) - 1 if dialogue else 1)
    waited_s = 0.0
    while known["state"] in UNDER_WAY and waited_s < patience_s:
        pause(POLL_S)
        waited_s += POLL_S
        known = answer_of(service, "GET", f"{path}/{known['id']}")
        yield from _lines(known, robot, shown)
        shown = len(known["lines"])
    yield _how_it_stands(known)


def _lines(known: dict[str, Any], robot: str, start: int) -> Iterator[str]:
    return (f"{robot}: {line['words']}" for line in known["lines"][start:] if line["by"] == robot)


def _how_it_stands(known: dict[str, Any]) -> str:
    state = known["state"]
    words = f"dialogue {known['id']} is {state.replace('_', ' ')}"
    if state == "asking":
        return f"{words}: answer with --dialogue {known['id']}"
    if state == "proposed":
        return f"{words}: say yes with --dialogue {known['id']}, or --approve next time"
    return f"{words}: {known['reason']}" if known["reason"] else words
