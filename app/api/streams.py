"""Server-sent events: the event log, resumable by `Last-Event-ID`, and the robots' telemetry."""

import threading
import time
from collections.abc import AsyncIterator, Callable
from typing import Annotated, Any

import anyio
from anyio import to_thread
from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent

from app.agents import RobotBoard
from app.database import EventRow
from app.errors import NotFound
from app.events import EventLog
from robots.clock import Clock

WAIT_S = 1.0
"""Longest block of a waiting stream, so that a closed connection is noticed."""
TELEMETRY_INTERVAL_S = 0.1


def envelope(row: EventRow) -> dict[str, Any]:
    return {"seq": row.seq, "time": row.time, "type": row.type, "subject": row.subject, "data": row.data}


def streams_router(
    *,
    events: EventLog,
    board: RobotBoard,
    clocks: dict[str, Clock],
    stopping: threading.Event,
    snapshot: Callable[[], list[tuple[str, str, dict[str, Any]]]],
) -> APIRouter:
    """
    :param stopping: once set, streams end.
    :param snapshot: the current state as (type, subject, data), sent first to a client that does not resume.
    """
    router = APIRouter(prefix="/v1", tags=["streams"])

    def known_world(world: str) -> str:
        # Before the stream begins: after that it is too late for a problem.
        if world not in clocks:
            raise NotFound(f"unknown world {world!r}", code="unknown-world", choices=sorted(clocks))
        return world

    @router.get("/events", response_class=EventSourceResponse)
    async def stream_events(
        request: Request,
        last_event_id: Annotated[int | None, Header(ge=0)] = None,
        after: Annotated[int | None, Query(ge=0, description="like Last-Event-ID")] = None,
    ) -> AsyncIterator[ServerSentEvent]:
        """The current state first, then every change; `Last-Event-ID` resumes after that event instead."""
        generation = events.generation
        seq = last_event_id if last_event_id is not None else after
        if seq is None:
            seq = await to_thread.run_sync(events.last)
            for type_, subject, data in await to_thread.run_sync(snapshot):
                state = {"seq": seq, "time": None, "type": type_, "subject": subject, "data": data}
                yield ServerSentEvent(data=state, id=str(seq))
        while not stopping.is_set() and not await request.is_disconnected():
            rows = await to_thread.run_sync(events.since, seq)
            for row in rows:
                seq = row.seq
                yield ServerSentEvent(data=envelope(row), id=str(seq))
            if not rows:
                generation = await to_thread.run_sync(events.wait, generation, WAIT_S)

    @router.get("/telemetry", response_class=EventSourceResponse)
    async def stream_telemetry(
        request: Request, world: Annotated[str, Depends(known_world)]
    ) -> AsyncIterator[ServerSentEvent]:
        """What the world's robots say of themselves, at most every 0.1 s; the newest of each."""
        generation = -1
        while not stopping.is_set() and not await request.is_disconnected():
            begun = time.monotonic()
            generation = await to_thread.run_sync(board.wait, generation, WAIT_S)
            yield ServerSentEvent(data=_telemetry(board, world, clocks[world].now_s()))
            pause_s = TELEMETRY_INTERVAL_S - (time.monotonic() - begun)
            if pause_s > 0:
                await anyio.sleep(pause_s)

    return router


def _telemetry(board: RobotBoard, world: str, now_s: float) -> dict[str, Any]:
    robots = {
        name: view.telemetry.model_dump(mode="json", exclude={"kind"})
        for name, view in board.views(world).items()
        if view.telemetry is not None
    }
    return {"world": world, "time_s": now_s, "robots": robots}
