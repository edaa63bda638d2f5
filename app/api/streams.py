"""Server-sent events: the event log, resumable by `Last-Event-ID`, and the robots' telemetry."""

import logging
import threading
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import anyio
from anyio import to_thread
from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent
from sqlalchemy.exc import SQLAlchemyError
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.agents import RobotBoard
from app.api.event_schema import RESET
from app.api.parameters import MAX_NAME_LENGTH
from app.api.problems import declared
from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.domain.errors import Busy, UnknownWorld
from app.store import EventRow, is_unavailable
from app.store.event_log import EventLog, envelope
from robots.clock import Clock
from robots.wire import Telemetry

WAIT_S = 1.0
"""The longest a stream waits before it checks whether its client has disconnected."""
TELEMETRY_INTERVAL_S = 0.1
AT_REST_INTERVAL_S = 1.0
"""Interval while the robots' telemetry does not change, so that clients notice a robot's silence."""
CHANGING_FIELDS = frozenset({"at_s", "battery", "sensing_j", "sensing_saved_j"})
"""Telemetry that changes with time alone."""
GREATEST_SEQ = 2**63 - 1
"""The greatest integer of the database."""

Snapshot = Callable[[], list[tuple[str, str, dict[str, Any]]]]


class OpenCount:
    """Counts the open `with` blocks; for the event loop's thread only."""

    def __init__(self) -> None:
        self.count = 0

    def __enter__(self) -> None:
        self.count += 1

    def __exit__(self, *_: object) -> None:
        self.count -= 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Streams:
    """The streams; each ends when its client disconnects or the service ends.

    :param stopping: once set, streams end.
    :param snapshot: the current state as (type, subject, data), sent first to a client that does not resume.
    :param max_open: streams that may be open at a time.
    :param waiting: limits the threads of waiting streams; not the default limiter, which a few dozen open streams
        would exhaust for all other requests.
    """

    events: EventLog
    board: RobotBoard
    clocks: Mapping[str, Clock]
    stopping: threading.Event
    snapshot: Snapshot
    waiting: anyio.CapacityLimiter
    max_open: int
    open: OpenCount = field(default_factory=OpenCount)
    wall: WallClock = SYSTEM_CLOCK

    async def changes(
        self, request: Request, seen: int | None, seq: int, *, state: bool
    ) -> AsyncIterator[ServerSentEvent]:
        """Every event after event `seen`.

        Begins with the current state if `seen` is None, greater than the newest event, or followed by events that are
        not kept any longer; in the last case a `stream.reset` comes first.

        :param seq: the newest event.
        :param state: False: a client without `seen` begins with the next event.
        """
        generation = self.events.generation
        # A number above the newest comes from another database, such as a deleted one: no event follows it here.
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
        """The events after `seq`; none while the database is unavailable, so that the stream survives that."""
        try:
            return await to_thread.run_sync(self.events.since, seq)
        except SQLAlchemyError as error:
            if not is_unavailable(error):
                raise
            await anyio.sleep(WAIT_S)
            return ()

    async def telemetry(self, request: Request, world: str) -> AsyncIterator[ServerSentEvent]:
        generation = -1
        sent = None
        sent_at_s = 0.0
        while world in self.clocks and await self._open(request):
            begun_s = self.wall.monotonic_s()
            generation = await self._wait(self.board.wait, generation)
            newest = _telemetry_of(self.board, world)
            if sent is None or begun_s - sent_at_s >= AT_REST_INTERVAL_S or not _is_unchanged(sent, newest):
                sent = newest
                sent_at_s = begun_s
                try:
                    now_s = self.clocks[world].now_s()
                except UnknownWorld:
                    return  # it was removed just now
                yield ServerSentEvent(data=_telemetry(world, now_s, newest))
            pause_s = TELEMETRY_INTERVAL_S - (self.wall.monotonic_s() - begun_s)
            if pause_s > 0:
                await anyio.sleep(pause_s)

    async def _state(self, seq: int) -> list[ServerSentEvent]:
        """The current state. Only its last item has the id, so a client that received only a part starts over."""
        items = [
            {"seq": seq, "time": None, "type": type_, "subject": subject, "data": data}
            for type_, subject, data in await to_thread.run_sync(self.snapshot)
        ]
        last = len(items) - 1
        return [
            ServerSentEvent(data=item, id=str(seq) if index == last else None)
            for index, item in enumerate(items)
        ]

    async def admit(self) -> AsyncIterator[None]:
        """A dependency that counts a stream from before its response until after its end.

        :raises Busy: if `max_open` streams are open.
        """
        if self.open.count >= self.max_open:
            raise Busy(
                f"{self.open.count} streams are open, the limit (MACTA_OPEN_STREAMS); close some",
                code="too-many-streams",
            )
        with self.open:
            yield

    async def _open(self, request: Request) -> bool:
        return not self.stopping.is_set() and not await request.is_disconnected()

    async def _wait(self, wait: Callable[[int, float], int], generation: int) -> int:
        return await to_thread.run_sync(wait, generation, WAIT_S, limiter=self.waiting)


class DepartureMiddleware:
    """ASGI middleware that does not treat a client's disconnection during a stream as an error.

    FastAPI closes a stream before it ends the task that writes to it; the task may then raise BrokenResourceError.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        has_left = False

        async def receiving() -> Message:
            nonlocal has_left
            message = await receive()
            has_left = has_left or message["type"] == "http.disconnect"
            return message

        try:
            await self._app(scope, receiving, send)
        except* anyio.BrokenResourceError:
            if not has_left:
                raise
            logging.getLogger(__name__).debug("a client left the stream %s", scope["path"])


def streams_router(
    *,
    events: EventLog,
    board: RobotBoard,
    clocks: Mapping[str, Clock],
    stopping: threading.Event,
    snapshot: Snapshot,
    max_open: int,
) -> APIRouter:
    """The routes; the parameters are those of `Streams`."""
    router = APIRouter(prefix="/v1", tags=["streams"])
    streams = Streams(
        events=events,
        board=board,
        clocks=clocks,
        stopping=stopping,
        snapshot=snapshot,
        waiting=anyio.CapacityLimiter(max_open),
        max_open=max_open,
    )

    limited = [Depends(streams.admit)]

    @router.get("/events", response_class=EventSourceResponse, dependencies=limited, responses=declared(429))
    async def stream_events(
        request: Request,
        # Read before the stream begins, so that an unavailable database is answered as a problem.
        newest: Annotated[int, Depends(events.last)],
        last_event_id: Annotated[int | None, Header(ge=0, le=GREATEST_SEQ)] = None,
        after: Annotated[int | None, Query(ge=0, le=GREATEST_SEQ, description="like Last-Event-ID")] = None,
        state: Annotated[
            bool, Query(description="false: begin with the next change, not with the state")
        ] = True,
    ) -> AsyncIterator[ServerSentEvent]:
        """The current state first, then every change; `Last-Event-ID` resumes after that event instead."""
        seen = after if last_event_id is None else last_event_id
        async for event in streams.changes(request, seen, newest, state=state):
            yield event

    _add_telemetry(router, streams)
    return router


def _add_telemetry(router: APIRouter, streams: Streams) -> None:
    def known_world(world: Annotated[str, Query(min_length=1, max_length=MAX_NAME_LENGTH)]) -> str:
        # Before the stream begins, so that it is answered as a problem.
        if world not in streams.clocks:
            raise UnknownWorld(world, streams.clocks)
        return world

    @router.get(
        "/telemetry",
        response_class=EventSourceResponse,
        dependencies=[Depends(streams.admit)],
        responses=declared(404, 429),
    )
    async def stream_telemetry(
        request: Request, world: Annotated[str, Depends(known_world)]
    ) -> AsyncIterator[ServerSentEvent]:
        """The newest telemetry of each of the world's robots.

        Ten times a second; once a second while only times, batteries and used energy change.
        """
        async for event in streams.telemetry(request, world):
            yield event


def _reset(seen: int | None) -> dict[str, Any]:
    """The event that tells a client that events it missed are no longer kept."""
    return {"seq": seen, "time": None, "type": RESET, "subject": "events", "data": {"seen": seen}}


def _telemetry_of(board: RobotBoard, world: str) -> Mapping[str, Telemetry]:
    return {name: view.telemetry for name, view in board.views(world).items() if view.telemetry is not None}


def _is_unchanged(before: Mapping[str, Telemetry], now: Mapping[str, Telemetry]) -> bool:
    """True if the same robots have the same telemetry except for `CHANGING_FIELDS`."""
    if before.keys() != now.keys():
        return False
    lasting = Telemetry.model_fields.keys() - CHANGING_FIELDS
    return all(
        was is now[name] or all(getattr(was, field) == getattr(now[name], field) for field in lasting)
        for name, was in before.items()
    )


def _telemetry(world: str, now_s: float, said: Mapping[str, Telemetry]) -> dict[str, Any]:
    robots = {name: told.model_dump(mode="json", exclude={"kind"}) for name, told in said.items()}
    return {"world": world, "time_s": now_s, "robots": robots}
