"""The sockets that join each page with the view in three dimensions: what a page shows goes one way, what is
picked in the view comes back to that page alone.

`/v1/views/{id}`: a page, under a random id of its own; it sends what it shows, a `Shown`, and is sent each `Pick`.
`/v1/views`: the view; it is sent `{"id", "shown"}` of each page, at first and whenever that changes (None once the
page is gone), and sends `{"id", "pick"}`. Sockets, not event streams: a browser grants a host six of those in all.
"""

import asyncio
from collections.abc import Coroutine
from typing import Any

from fastapi import APIRouter, WebSocket
from pydantic import BaseModel, ValidationError
from starlette.websockets import WebSocketDisconnect

from app.api.page_views import Follower, Page, PageViews, Pick, Shown
from app.api.streams import Count
from app.api.viewer_proxy import POLICY_VIOLATION, TRY_AGAIN_LATER, ViewId

LONGEST_FRAME = 4096


class Picked(BaseModel):
    """What was picked, and in which page's view."""

    id: str
    pick: Pick


class Changed(BaseModel):
    """What a page shows now; nothing once it is gone."""

    id: str
    shown: Shown | None


def views_router(views: PageViews, *, most: int) -> APIRouter:
    """:param most: so many sockets may be open at a time."""
    router, open_ = APIRouter(prefix="/v1"), Count()

    @router.websocket("/views/{view_id}")
    async def page(socket: WebSocket, view_id: ViewId) -> None:
        await socket.accept()
        if open_.count >= most:
            await socket.close(TRY_AGAIN_LATER)
            return
        with open_, views.page(view_id) as page:
            await _either(socket, _take_shown(socket, views, view_id, page), _hand_picks(socket, page))

    @router.websocket("/views")
    async def follow(socket: WebSocket) -> None:
        await socket.accept()
        if open_.count >= most:
            await socket.close(TRY_AGAIN_LATER)
            return
        with open_, views.follower() as follower:
            await _either(socket, _take_picks(socket, views), _hand_changes(socket, follower))

    return router


async def _either(socket: WebSocket, *directions: Coroutine[Any, Any, None]) -> None:
    """Both directions of a socket until one ends: the client left, or said what nobody understands."""
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
            pass  # it left, perhaps while it was being told


async def _take_shown(socket: WebSocket, views: PageViews, view_id: str, page: Page) -> None:
    while True:
        views.show(view_id, page, Shown.model_validate_json(await _frame(socket)))


async def _hand_picks(socket: WebSocket, page: Page) -> None:
    while True:
        await socket.send_text((await page.picks.get()).model_dump_json())


async def _take_picks(socket: WebSocket, views: PageViews) -> None:
    while True:
        picked = Picked.model_validate_json(await _frame(socket))
        views.pick(picked.id, picked.pick)


async def _hand_changes(socket: WebSocket, follower: Follower) -> None:
    while True:
        for view_id, shown in (await follower.changes()).items():
            await socket.send_text(Changed(id=view_id, shown=shown).model_dump_json())


async def _frame(socket: WebSocket) -> str:
    """The next text frame; one that is too long to be ours is as good as none."""
    text = await socket.receive_text()
    return text if len(text) <= LONGEST_FRAME else ""
