"""Connects each open page with the 3D view: the page's state goes to the view, picks in the view go back to the page.

`/v1/views/{id}`: a page, under a random id of its own; it sends its state (`Shown`) and receives each `Pick`.
`/v1/views`: the view; it receives `{"id", "shown"}` of each page, at first and after every change (`shown` is null once
the page is closed), and sends `{"id", "pick"}`. WebSockets, not event streams: a browser opens only six of those for a
host.

Kept in memory while the page is connected, and used by the event loop's thread only.
"""

import asyncio
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

from fastapi import APIRouter, WebSocket
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from starlette.websockets import WebSocketDisconnect

from app.api.streams import OpenCount
from app.api.viewer_proxy import POLICY_VIOLATION, TRY_AGAIN_LATER, ViewId

MAX_PICKS = 16
"""Picks that wait for a page; further ones are dropped."""
MAX_FRAME_LENGTH = 4096


class ViewPart(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False, str_max_length=200)


class Cursor(ViewPart):
    """An instant of a recording, by the world's clock."""

    mission_id: str
    time_s: float


class Shown(ViewPart):
    """A page's state: its world, selection and camera."""

    world: str | None = None
    robot: str | None = None
    sample: str | None = None
    plan_id: str | None = None
    action: str | None = Field(default=None, description="the selected action of the plan")
    follow: bool = Field(default=False, description="the camera follows the robot")
    whole: int = Field(default=0, description="increases when the camera is to show the whole world again")
    replay: Cursor | None = None
    seen: bool = Field(default=True, description="false: the page is hidden, or shows its map instead")
    dark: bool = Field(default=False, description="the page's theme is dark")


class Pick(ViewPart):
    """Something clicked in the 3D view."""

    kind: Literal["robot", "sample", "place"]
    name: str


@dataclass(slots=True)
class Page:
    """An open page: its state (None before it was sent) and its picks."""

    shown: Shown | None = None
    picks: asyncio.Queue[Pick] = field(default_factory=lambda: asyncio.Queue(MAX_PICKS))


class Follower:
    """A view that draws the pages' states; collects the ids of pages that have changed."""

    def __init__(self, views: "PageViews") -> None:
        self._views = views
        self._changed = asyncio.Event()
        self._ids = set(views.ids)
        self._changed.set()

    def note_change(self, view_id: str) -> None:
        self._ids.add(view_id)
        self._changed.set()

    async def changes(self) -> dict[str, Shown | None]:
        """Wait for changes; None for a page that is closed or has sent no state."""
        await self._changed.wait()
        self._changed.clear()
        ids = self._ids
        self._ids = set()
        return {view_id: self._views.shown(view_id) for view_id in ids}


class PageViews:
    """The open pages by their ids, and the views that follow them."""

    def __init__(self) -> None:
        self._pages: dict[str, Page] = {}
        self._followers: set[Follower] = set()

    @property
    def ids(self) -> frozenset[str]:
        return frozenset(self._pages)

    def shown(self, view_id: str) -> Shown | None:
        page = self._pages.get(view_id)
        return None if page is None else page.shown

    @contextmanager
    def page(self, view_id: str) -> Iterator[Page]:
        """A page within the block; a page that connects again replaces its earlier connection."""
        page = self._pages[view_id] = Page()
        try:
            yield page
        finally:
            if self._pages.get(view_id) is page:
                del self._pages[view_id]
                self._notify(view_id)

    def show(self, view_id: str, page: Page, shown: Shown) -> None:
        if self._pages.get(view_id) is page and page.shown != shown:
            page.shown = shown
            self._notify(view_id)

    def pick(self, view_id: str, pick: Pick) -> None:
        """Queue the pick for the page if it is open and has room."""
        page = self._pages.get(view_id)
        if page is not None and not page.picks.full():
            page.picks.put_nowait(pick)

    @contextmanager
    def follower(self) -> Iterator[Follower]:
        follower = Follower(self)
        self._followers.add(follower)
        try:
            yield follower
        finally:
            self._followers.discard(follower)

    def _notify(self, view_id: str) -> None:
        for follower in self._followers:
            follower.note_change(view_id)


class Picked(BaseModel):
    """A pick, and the page it is for."""

    id: str
    pick: Pick


class Changed(BaseModel):
    """A page's new state; None once it is closed."""

    id: str
    shown: Shown | None


def views_router(views: PageViews, *, max_open: int) -> APIRouter:
    """:param max_open: sockets that may be open at a time."""
    router = APIRouter(prefix="/v1")
    open_ = OpenCount()

    @router.websocket("/views/{view_id}")
    async def page(socket: WebSocket, view_id: ViewId) -> None:
        await socket.accept()
        if open_.count >= max_open:
            await socket.close(TRY_AGAIN_LATER)
            return
        with open_, views.page(view_id) as page:
            await _run_both(socket, _receive_states(socket, views, view_id, page), _send_picks(socket, page))

    @router.websocket("/views")
    async def follow(socket: WebSocket) -> None:
        await socket.accept()
        if open_.count >= max_open:
            await socket.close(TRY_AGAIN_LATER)
            return
        with open_, views.follower() as follower:
            await _run_both(socket, _receive_picks(socket, views), _send_changes(socket, follower))

    return router


async def _run_both(socket: WebSocket, *directions: Coroutine[Any, Any, None]) -> None:
    """Run both directions of a socket until one ends: the client has left or sent something malformed."""
    tasks = {asyncio.create_task(direction) for direction in directions}
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        try:
            task.result()
        except (ValidationError, KeyError):
            await socket.close(POLICY_VIOLATION)
        except (WebSocketDisconnect, RuntimeError):
            pass  # the client has left


async def _receive_states(socket: WebSocket, views: PageViews, view_id: str, page: Page) -> None:
    while True:
        views.show(view_id, page, Shown.model_validate_json(await _frame(socket)))


async def _send_picks(socket: WebSocket, page: Page) -> None:
    while True:
        await socket.send_text((await page.picks.get()).model_dump_json())


async def _receive_picks(socket: WebSocket, views: PageViews) -> None:
    while True:
        picked = Picked.model_validate_json(await _frame(socket))
        views.pick(picked.id, picked.pick)


async def _send_changes(socket: WebSocket, follower: Follower) -> None:
    while True:
        for view_id, shown in (await follower.changes()).items():
            await socket.send_text(Changed(id=view_id, shown=shown).model_dump_json())


async def _frame(socket: WebSocket) -> str:
    """The next text frame; one that is too long counts as malformed."""
    text = await socket.receive_text()
    return text if len(text) <= MAX_FRAME_LENGTH else ""
