"""What each open page shows of the world, for the view in three dimensions; and what is picked there, for that page.

Kept in memory and only as long as the page is connected: never a record. All of it in the event loop's one thread.
"""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

MOST_PICKS = 16
"""That a page has not yet taken; further ones are dropped."""


class ViewPart(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False, str_max_length=200)


class Cursor(ViewPart):
    """An instant of a recording, by the world's clock."""

    mission_id: str
    time_s: float


class Shown(ViewPart):
    """What a page shows: its world, what is selected there, where the camera is to be."""

    world: str | None = None
    robot: str | None = None
    sample: str | None = None
    plan_id: str | None = None
    action: str | None = Field(default=None, description="the plan's action that is looked at")
    follow: bool = Field(default=False, description="the camera goes with the robot")
    whole: int = Field(default=0, description="grows whenever the camera is to show the whole world again")
    replay: Cursor | None = None
    seen: bool = Field(default=True, description="false: the page is hidden, or shows its map instead")
    dark: bool = Field(default=False, description="the page's theme is dark")


class Pick(ViewPart):
    """What somebody clicked on in three dimensions."""

    kind: Literal["robot", "sample", "place"]
    name: str


@dataclass(slots=True)
class Page:
    """An open page: what it shows, None before it has said so, and what was picked for it."""

    shown: Shown | None = None
    picks: asyncio.Queue[Pick] = field(default_factory=lambda: asyncio.Queue(MOST_PICKS))


class Follower:
    """Somebody who draws what the pages show: hears of those that changed, the newest of each only."""

    def __init__(self, views: "PageViews") -> None:
        self._views = views
        self._changed = asyncio.Event()
        self._ids = set(views.ids)
        self._changed.set()

    def hear(self, view_id: str) -> None:
        self._ids.add(view_id)
        self._changed.set()

    async def changes(self) -> dict[str, Shown | None]:
        """Waits for changes; None for a page that is closed or has said nothing yet."""
        await self._changed.wait()
        self._changed.clear()
        ids, self._ids = self._ids, set()
        return {view_id: self._views.shown(view_id) for view_id in ids}


class PageViews:
    """The open pages by the id that each has given itself, and who follows them."""

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
        """A page for as long as it is connected. One that comes again takes the place of its lost connection."""
        page = self._pages[view_id] = Page()
        try:
            yield page
        finally:
            if self._pages.get(view_id) is page:
                del self._pages[view_id]
                self._tell(view_id)

    def show(self, view_id: str, page: Page, shown: Shown) -> None:
        if self._pages.get(view_id) is page and page.shown != shown:
            page.shown = shown
            self._tell(view_id)

    def pick(self, view_id: str, pick: Pick) -> None:
        """Hand on to the page, if it is still there and takes what it is handed."""
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

    def _tell(self, view_id: str) -> None:
        for follower in self._followers:
            follower.hear(view_id)
