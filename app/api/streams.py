"""Server-sent events: the event log, resumable by `Last-Event-ID`, and the robots' telemetry."""

import threading
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import anyio
from anyio import to_thread
from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent
from sqlalchemy.exc import DBAPIError

from app.agents import RobotBoard
from app.api.event_schema import RESET
from app.api.problems import declared
from app.domain.errors import Busy, NotFound
from app.store import EventRow, is_unavailable
from app.store.event_log import EventLog
from robots.clock import Clock
from robots.wire import Telemetry

WAIT_S = 1.0
"""Longest block of a waiting stream, so that a closed connection is noticed."""
TELEMETRY_INTERVAL_S = 0.1
AT_REST_INTERVAL_S = 1.0
"""Between two words of robots that tell the same as before: only so that their silence would be noticed."""
PASSING = frozenset({"at_s", "battery", "sensing_j", "sensing_saved_j"})
"""What robots tell that changes with time alone."""
GREATEST_SEQ = 2**63 - 1
"""Of the record's integers."""

Snapshot = Callable[[], list[tuple[str, str, dict[str, Any]]]]


def envelope(row: EventRow) -> dict[str, Any]:
    return {"seq": row.seq, "time": row.time, "type": row.type, "subject": row.subject, "data": row.data}


class Count:
    """How many blocks are entered; all in the one thread of the event loop."""

    def __init__(self) -> None:
        self.count = 0

    def __enter__(self) -> None:
        self.count += 1

    def __exit__(self, *_: object) -> None:
        self.count -= 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Streams:
    """What the streams tell, each until its client leaves or the service ends.

    :param stopping: once set, streams end.
    :param snapshot: the current state as (type, subject, data), sent first to a client that does not resume.
    :param most: so many streams may be open at a time.
    :param waiting: the threads of waiting streams. Never those that other requests are answered in: a few
        dozen open pages would take them all.
    """

    events: EventLog
    board: RobotBoard
    clocks: Mapping[str, Clock]
    stopping: threading.Event
    snapshot: Snapshot
    waiting: anyio.CapacityLimiter
    most: int
    open: Count = field(default_factory=Count)

    async def changes(
        self, request: Request, seen: int | None, seq: int, *, state: bool
    ) -> AsyncIterator[ServerSentEvent]:
        """Every change after event `seen`; the current state first where nothing or too much was seen.

        So also where changes after it are not kept any more, and a word of that before.

        :param seq: the newest event.
        :param state: whether a client that begins is told the current state.
        """
        generation = self.events.generation
        # An event above the newest is of another record, say one begun afresh: nothing follows it here.
        forgotten = seen is not None and await to_thread.run_sync(self.events.has_forgotten, seen)
        if forgotten:
            yield ServerSentEvent(data=_reset(seen))
        if seen is None and not state:
            seen = seq
        if seen is None or seen > seq or forgotten:
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
            if not is_unavailable(error):
                raise
            await anyio.sleep(WAIT_S)
            return ()

    async def telemetry(self, request: Request, world: str) -> AsyncIterator[ServerSentEvent]:
        generation, told, told_at = -1, None, 0.0
        while await self._open(request):
            begun = time.monotonic()
            generation = await self._wait(self.board.wait, generation)
            said = _said(self.board, world)
            if told is None or begun - told_at >= AT_REST_INTERVAL_S or not _at_rest(told, said):
                told, told_at = said, begun
                yield ServerSentEvent(data=_telemetry(world, self.clocks[world].now_s(), said))
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

    def refuse_too_many(self) -> None:
        """:raises Busy: if as many streams are open as may be."""
        if self.open.count >= self.most:
            raise Busy(
                f"{self.open.count} streams are open, as many as may be (MACTA_OPEN_STREAMS); close some",
                code="too-many-streams",
            )

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
    most: int,
) -> APIRouter:
    """The routes of `Streams`, which says what the parameters are."""
    router = APIRouter(prefix="/v1", tags=["streams"])
    streams = Streams(
        events=events,
        board=board,
        clocks=clocks,
        stopping=stopping,
        snapshot=snapshot,
        waiting=anyio.CapacityLimiter(most),
        most=most,
    )

    room = [Depends(streams.refuse_too_many)]

    @router.get("/events", response_class=EventSourceResponse, dependencies=room, responses=declared(429))
    async def stream_events(
        request: Request,
        # Read before the stream begins: while the database is away that is told as a problem.
        newest: Annotated[int, Depends(events.last)],
        last_event_id: Annotated[int | None, Header(ge=0, le=GREATEST_SEQ)] = None,
        after: Annotated[int | None, Query(ge=0, le=GREATEST_SEQ, description="like Last-Event-ID")] = None,
        state: Annotated[
            bool, Query(description="false: begin with the next change, not with the state")
        ] = True,
    ) -> AsyncIterator[ServerSentEvent]:
        """The current state first, then every change; `Last-Event-ID` resumes after that event instead."""
        with streams.open:
            seen = after if last_event_id is None else last_event_id
            async for event in streams.changes(request, seen, newest, state=state):
                yield event

    _add_telemetry(router, streams)
    return router


def _add_telemetry(router: APIRouter, streams: Streams) -> None:
    def known_world(world: str) -> str:
        # Before the stream begins: after that it is too late for a problem.
        if world not in streams.clocks:
            raise NotFound(f"unknown world {world!r}", code="unknown-world", choices=sorted(streams.clocks))
        return world

    @router.get(
        "/telemetry",
        response_class=EventSourceResponse,
        dependencies=[Depends(streams.refuse_too_many)],
        responses=declared(404, 429),
    )
    async def stream_telemetry(
        request: Request, world: Annotated[str, Depends(known_world)]
    ) -> AsyncIterator[ServerSentEvent]:
        """What the world's robots say of themselves; the newest of each.

        Ten times a second; once a second while nothing but time, batteries and energy used has changed.
        """
        with streams.open:
            async for event in streams.telemetry(request, world):
                yield event


def _reset(seen: int | None) -> dict[str, Any]:
    """What a client missed is not to be had any more; the current state follows."""
    return {"seq": seen, "time": None, "type": RESET, "subject": "events", "data": {"seen": seen}}


def _said(board: RobotBoard, world: str) -> Mapping[str, Telemetry]:
    return {name: view.telemetry for name, view in board.views(world).items() if view.telemetry is not None}


def _at_rest(before: Mapping[str, Telemetry], now: Mapping[str, Telemetry]) -> bool:
    """True if the same robots say the same, but for what changes with time alone."""
    if before.keys() != now.keys():
        return False
    lasting = Telemetry.model_fields.keys() - PASSING
    return all(
        was is now[name] or all(getattr(was, field) == getattr(now[name], field) for field in lasting)
        for name, was in before.items()
    )


def _telemetry(world: str, now_s: float, said: Mapping[str, Telemetry]) -> dict[str, Any]:
    robots = {name: told.model_dump(mode="json", exclude={"kind"}) for name, told in said.items()}
    return {"world": world, "time_s": now_s, "robots": robots}
