"""Waiting for what other threads and processes do. Every wait has an end, and says what it waited for in vain."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import httpx2

LOOK_S = 0.02
LONGEST_LOOK_S = 0.08
"""Of a wait for what a service tells: a request takes some 10 ms of CPU, which the service itself lacks meanwhile."""
LONG_S = 60.0
ENDED = ("completed", "partially_completed", "failed", "cancelled")
"""The states that a mission ends in. It may be `unknown` before: the fake world's time goes on while a busy machine
keeps its messages waiting."""

Thing = TypeVar("Thing")


def until(
    true: Callable[[], object], what: object = "that never came true", within_s: float = LONG_S
) -> None:
    """Look until it is true."""
    give_up = time.monotonic() + within_s
    while not true():
        assert time.monotonic() < give_up, what
        time.sleep(LOOK_S)


def awaited(read: Callable[[], Thing], holds: Callable[[Thing], object], within_s: float = LONG_S) -> Thing:
    """Read something until it is so; that reading."""
    give_up = time.monotonic() + within_s
    look_s = LOOK_S
    while not holds(thing := read()):
        assert time.monotonic() < give_up, thing
        time.sleep(look_s)
        look_s = min(1.2 * look_s, LONGEST_LOOK_S)
    return thing


def read_until(
    api: httpx2.Client, path: str, holds: Callable[[dict[str, Any]], object], within_s: float = LONG_S
) -> dict[str, Any]:
    """Read what is at `path` until it is so; that reading."""
    return awaited(lambda: api.get(path).json(), holds, within_s)


def mission_of(api: httpx2.Client, goal: str) -> str:
    """The mission that carries a goal out, once there is one; it may have ended by then.

    :param goal: its id.
    """
    mission: str = read_until(api, f"/v1/goals/{goal}", lambda one: one["mission_id"])["mission_id"]
    return mission


def in_state(api: httpx2.Client, path: str, *states: str, within_s: float = LONG_S) -> dict[str, Any]:
    """Read what is at `path` until it is in one of the states; that reading."""
    return read_until(api, path, lambda thing: thing["state"] in states, within_s)
