"""What a client observes of a service across restarts: goals, deadlines, the world's time, the event stream."""

import json
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

import httpx2

from app.workflows.background import Background

ENDED = ("finished", "withdrawn", "unsolvable")
QUIET_S = 2.0
"""Silence after which a stream is taken to have sent everything for now."""
RETRY_S = 0.2


class Observer:
    """Reads goals and the world's time; `complaints` lists deadlines that moved and times that went back."""

    def __init__(self, world: str) -> None:
        self._world = world
        self.goals: dict[str, dict[str, Any]] = {}
        """By id, as last seen."""
        self._deadlines: dict[str, set[float | None]] = {}
        self._clocks_s: dict[str, list[float]] = {}

    def read(self, api: httpx2.Client, goal_ids: Iterable[str], *, clock: str = "") -> None:
        """
        :param clock: a name for the clock that is read: each replica has its own copy of the world's clock.
        :raises httpx2.TransportError: if the service ends meanwhile.
        :raises httpx2.HTTPStatusError: if it answers with an error.
        """
        time_s = api.get(f"/v1/worlds/{self._world}").raise_for_status().json()["time_s"]
        self._clocks_s.setdefault(clock, []).append(time_s)
        for goal_id in goal_ids:
            goal = api.get(f"/v1/goals/{goal_id}").raise_for_status().json()
            self.goals[goal_id] = goal
            self._deadlines.setdefault(goal_id, set()).add(goal["deadline_at_s"])

    @property
    def time_s(self) -> float:
        """The world's time when it was last read from the first clock; 0 before."""
        return next((times_s[-1] for times_s in self._clocks_s.values()), 0.0)

    @property
    def open(self) -> list[dict[str, Any]]:
        return [goal for goal in self.goals.values() if goal["state"] not in ENDED]

    @property
    def complaints(self) -> list[str]:
        back = [
            f"the world's time went back from {before:.2f} s to {after:.2f} s"
            for times_s in self._clocks_s.values()
            for before, after in pairwise(times_s)
            if after < before
        ]
        moved = [
            f"the deadline of {goal_id} was at {sorted(map(str, instants))}"
            for goal_id, instants in self._deadlines.items()
            if len(instants) > 1
        ]
        return [*back, *moved]


def event_numbers(api: httpx2.Client, after: int) -> Iterator[int]:
    """Numbers of the events after a number, until silence (`httpx2.ReadTimeout`) or the end of the service."""
    headers = {"last-event-id": str(after)}
    with api.stream("GET", "/v1/events", headers=headers, timeout=QUIET_S) as answer:
        answer.raise_for_status()
        for line in answer.iter_lines():
            if line.startswith("data:"):
                yield json.loads(line[5:])["seq"]


class EventFollower:
    """Follows the event stream in a background thread across restarts, as a console does."""

    def __init__(self, api: Callable[[], httpx2.Client]) -> None:
        """:param api: a client of the present service process; may raise anything while there is none."""
        self._api = api
        self._lock = threading.Lock()
        self._seen: list[int] = []
        self._background = Background("follower", self._run)

    @property
    def seen(self) -> list[int]:
        """The events' numbers, in the order of arrival."""
        with self._lock:
            return list(self._seen)

    @contextmanager
    def following(self) -> Iterator[None]:
        """Follow the stream for the length of the block."""
        self._background.start()
        try:
            yield
        finally:
            self._background.end()

    def _run(self) -> None:
        while not self._background.ending.is_set():
            try:
                with self._api() as api:
                    for number in event_numbers(api, self._seen[-1] if self._seen else 0):
                        with self._lock:
                            self._seen.append(number)
                        if self._background.ending.is_set():
                            return
            except Exception:  # the service was killed, or is starting
                self._background.ending.wait(RETRY_S)
