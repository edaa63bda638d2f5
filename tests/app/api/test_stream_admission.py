"""Streams are counted before they are answered; a client that leaves one is no defect."""

import asyncio
import logging
import threading
from collections import Counter
from collections.abc import Iterator

import pytest
from fastapi import FastAPI
from starlette.types import Message, Scope

from app.api import problems
from app.api.streams import DepartureMiddleware, streams_router

MAX_OPEN = 3
STATE_ITEMS = 50


class QuietLog:
    """An event log in which nothing happens."""

    generation = 0

    def last(self) -> int:
        return 0

    def since(self, _: int) -> tuple[()]:
        return ()

    def wait(self, generation: int, _: float) -> int:
        return generation


class Client:
    """Follows `/v1/events` by ASGI; leaves when it is told to, or after a number of messages."""

    def __init__(self, app: FastAPI, *, leaves_after: int | None = None) -> None:
        self._app = app
        self._leaves_after = leaves_after
        self._requested = False
        self.status = 0
        self.got = 0
        self.answered = asyncio.Event()
        self.leaves = asyncio.Event()

    async def follow(self) -> None:
        scope: Scope = {
            "type": "http",
            "asgi": {"version": "3.0", "spec_version": "2.3"},
            "http_version": "1.1",
            "method": "GET",
            "scheme": "http",
            "path": "/v1/events",
            "raw_path": b"/v1/events",
            "root_path": "",
            "query_string": b"",
            "headers": [],
            "server": ("service", 80),
            "client": ("client", 1),
            "state": {},
        }
        await self._app(scope, self._receive, self._send)

    async def _receive(self) -> Message:
        if not self._requested:
            self._requested = True
            return {"type": "http.request", "body": b"", "more_body": False}
        await self.leaves.wait()
        return {"type": "http.disconnect"}

    async def _send(self, message: Message) -> None:
        self.status = message.get("status", self.status)
        self.answered.set()
        # As on a slow link: what is to be sent is ready before what was sent is through.
        for _ in range(10):
            await asyncio.sleep(0)
        self.got += 1
        if self.got == self._leaves_after:
            self.leaves.set()


@pytest.fixture
def app() -> Iterator[FastAPI]:
    stopping = threading.Event()
    app = FastAPI()
    problems.install(app)
    app.include_router(
        streams_router(
            events=QuietLog(),  # type: ignore[arg-type]
            board=None,  # type: ignore[arg-type]
            clocks={},
            stopping=stopping,
            snapshot=lambda: [("goal.state", "g", {})] * STATE_ITEMS,
            max_open=MAX_OPEN,
        )
    )
    app.add_middleware(DepartureMiddleware)
    yield app
    stopping.set()


async def open_at_once(app: FastAPI, count: int) -> Counter[int]:
    """How often each status was answered to a number of clients at once; all have left at the end."""
    clients = [Client(app) for _ in range(count)]
    following = [asyncio.create_task(client.follow()) for client in clients]
    for client in clients:
        await client.answered.wait()
    for client in clients:
        client.leaves.set()
    await asyncio.gather(*following)
    return Counter(client.status for client in clients)


def test_of_streams_that_are_opened_at_once_only_so_many_get_in(app: FastAPI) -> None:
    assert asyncio.run(open_at_once(app, 4 * MAX_OPEN)) == {200: MAX_OPEN, 429: 3 * MAX_OPEN}


def test_streams_that_have_ended_make_room(app: FastAPI) -> None:
    async def twice() -> Counter[int]:
        await open_at_once(app, MAX_OPEN)
        return await open_at_once(app, MAX_OPEN)

    assert asyncio.run(twice()) == {200: MAX_OPEN}


def test_a_client_that_leaves_is_one_debug_line(app: FastAPI, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG, logger="app"):
        asyncio.run(Client(app, leaves_after=3).follow())
    assert [(record.levelname, record.exc_info) for record in caplog.records] == [("DEBUG", None)]
    assert "/v1/events" in caplog.text
