"""An answer that is held back, so that the page gets a later one before it."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import APIResponse, Page, Route


@dataclass(frozen=True, slots=True)
class Held:
    """The first answer that the page was to get, taken from the service at once."""

    page: "Page"
    taken: list[tuple["Route", "APIResponse"]] = field(default_factory=list)

    def wait(self) -> None:
        while not self.taken:
            self.page.wait_for_timeout(50)

    def hand_over(self) -> None:
        """Give it to the page after all, and leave the page time to draw it."""
        route, answer = self.taken[0]
        with self.page.expect_event("requestfinished", lambda request: request == route.request):
            route.fulfill(response=answer)
        self.page.wait_for_timeout(300)


def hold_first(page: "Page", what: str) -> Held:
    """Hold back the first answer, from now on, to a question of this kind; the later ones pass."""
    held = Held(page)

    def take(route: "Route") -> None:
        if held.taken:
            route.continue_()
        else:
            held.taken.append((route, route.fetch()))

    page.route(what, take)
    return held
