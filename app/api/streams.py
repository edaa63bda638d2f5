"""Server-sent events: the event log, resumable by `Last-Event-ID`, and the robots' telemetry."""

import threading
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import anyio
from anyio import to_thread
from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent
from sqlalchemy.exc import DBAPIError

from app.agents import RobotBoard
from app.database import EventRow, is_away
from app.errors import NotFound
from app.events import EventLog
from robots.clock import Clock

WAIT_S = 1.0
"""Longest block of a waiting stream, so that a closed connection is noticed."""
TELEMETRY_INTERVAL_S = 0.1
WAITING_STREAMS = 500
"""Streams that wait at a time; any more take turns."""
GREATEST_SEQ = 2**63 - 1
"""Of the record's integers."""

Snapshot = Callable[[], list[tuple[str, str, dict[str, Any]]]]


def envelope(row: EventRow) -> dict[str, Any]:
    return {"seq": row.seq, "time": row.time, "type": row.type, "subject": row.subject, "data": row.data}


@dataclass(frozen=True, slots=True, kw_only=True)
class Streams:
    """What the streams tell, each until its client leaves or the service ends.

    :param stopping: once set, streams end.
    :param snapshot: the current state as (type, subject, data), sent first to a client that does not resume.
    :param waiting: the threads of waiting streams. Never those that other requests are answered in: a few
        dozen open pages would take them all.
    """

    events: EventLog
    board: RobotBoard
    clocks: Mapping[str, Clock]
    stopping: threading.Event
    snapshot: Snapshot
    waiting: anyio.CapacityLimiter

    async def changes(self, request: Request, seen: int | None) -> AsyncIterator[ServerSentEvent]:
        """Every change after event `seen`; the current state first where nothing or too much was seen."""
        generation = self.events.generation
        seq = await to_thread.run_sync(self.events.last)
        # An event above the newest is of another record, say one begun afresh: nothing follows it here.
        if seen is None or seen > seq:
            for event in await self._state(seq):
                yield event
        else:
            seq = seen
        while await self._open(request):
            rows = await self._since(seq)
            for row in rows:
                seq = row.seq
                yield ServerSentEvent(data=envelope(row), id=str(seq))
            if not rows:
                generation = await self._wait(self.events.wait, generation)

    async def _since(self, seq: int) -> Sequence[EventRow]:
        """The events after `seq`; none while the database is away, a stream that is open goes on when it is back."""
        try:
            return await to_thread.run_sync(self.events.since, seq)
        except DBAPIError as error:
            if not is_away(error):
                raise
            await anyio.sleep(WAIT_S)
            return ()

    async def telemetry(self, request: Request, world: str) -> AsyncIterator[ServerSentEvent]:
        generation = -1
        while await self._open(request):
            begun = time.monotonic()
            generation = await self._wait(self.board.wait, generation)
            yield ServerSentEvent(data=_telemetry(self.board, world, self.clocks[world].now_s()))
            pause_s = TELEMETRY_INTERVAL_S - (time.monotonic() - begun)
            if pause_s > 0:
                await anyio.sleep(pause_s)

    async def _state(self, seq: int) -> list[ServerSentEvent]:
        """The current state. Its last item alone carries the id: who saw only part of it begins again."""
        items = [
            {"seq": seq, "time": None, "type": type_, "subject": subject, "data": data}
            for type_, subject, data in await to_thread.run_sync(self.snapshot)
        ]
        last = len(items) - 1
        return [
            ServerSentEvent(data=item, id=str(seq) if index == last else None)
            for index, item in enumerate(items)
        ]

    async def _open(self, request: Request) -> bool:
        return not self.stopping.is_set() and not await request.is_disconnected()

    async def _wait(self, wait: Callable[[int, float], int], generation: int) -> int:
        return await to_thread.run_sync(wait, generation, WAIT_S, limiter=self.waiting)


def streams_router(
    *,
    events: EventLog,
    board: RobotBoard,
    clocks: Mapping[str, Clock],
    stopping: threading.Event,
    snapshot: Snapshot,
) -> APIRouter:
    """The routes of `Streams`, which says what the parameters are."""
    router = APIRouter(prefix="/v1", tags=["streams"])
    streams = Streams(
        events=events,
        board=board,
        clocks=clocks,
        stopping=stopping,
        snapshot=snapshot,
        waiting=anyio.CapacityLimiter(WAITING_STREAMS),
    )

    @router.get("/events", response_class=EventSourceResponse)
    async def stream_events(
        request: Request,
        last_event_id: Annotated[int | None, Header(ge=0, le=GREATEST_SEQ)] = None,
        after: Annotated[int | None, Query(ge=0, le=GREATEST_SEQ, description="like Last-Event-ID")] = None,
    ) -> AsyncIterator[ServerSentEvent]:
        """The current state first, then every change; `Last-Event-ID` resumes after that event instead."""
        async for event in streams.changes(request, after if last_event_id is None else last_event_id):
            yield event

    _add_telemetry(router, streams)
    return router


def _add_telemetry(router: APIRouter, streams: Streams) -> None:
    def known_world(world: str) -> str:
        # Before the stream begins: after that it is too late for a problem.
        if world not in streams.clocks:
            raise NotFound(f"unknown world {world!r}", code="unknown-world", choices=sorted(streams.clocks))
        return world

    @router.get("/telemetry", response_class=EventSourceResponse)
    async def stream_telemetry(
        request: Request, world: Annotated[str, Depends(known_world)]
    ) -> AsyncIterator[ServerSentEvent]:
        """What the world's robots say of themselves, at most every 0.1 s; the newest of each."""
        async for event in streams.telemetry(request, world):
            yield event


def _telemetry(board: RobotBoard, world: str, now_s: float) -> dict[str, Any]:
    robots = {
        name: view.telemetry.model_dump(mode="json", exclude={"kind"})
        for name, view in board.views(world).items()
        if view.telemetry is not None
    }
    return {"world": world, "time_s": now_s, "robots": robots}
