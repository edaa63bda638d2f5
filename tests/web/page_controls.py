"""What tests do with a page beside clicking: measure it, hide it, delay an answer."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import APIResponse, Page, Route

Box = dict[str, float]

MEASURE = "(names) => names.map((name) => document.querySelector(name).getBoundingClientRect().toJSON())"
HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""


def boxes(page: "Page", *selectors: str) -> Sequence[Box]:
    """The first element of each selector: `x`, `y`, `width`, `height`, pixels from the window's upper left.

    Measured in one evaluate() call, for the page may change between two.
    """
    measured: Sequence[Box] = page.evaluate(MEASURE, selectors)
    return measured


def hide(page: "Page", *, hidden: bool = True) -> None:
    """Make the page believe that it is not visible; headless browsers never hide one."""
    page.evaluate(HIDE, hidden)


@dataclass(frozen=True, slots=True)
class HeldAnswer:
    """The first answer to a request, taken from the service at once and kept from the page."""

    page: "Page"
    taken: list[tuple["Route", "APIResponse"]] = field(default_factory=list)

    def wait(self) -> None:
        while not self.taken:
            self.page.wait_for_timeout(20)

    def hand_over(self) -> None:
        """Give it to the page, and leave the page time to draw it."""
        route, answer = self.taken[0]
        with self.page.expect_event("requestfinished", lambda request: request == route.request):
            route.fulfill(response=answer)
        self.page.wait_for_timeout(300)


def hold_first(page: "Page", pattern: str) -> HeldAnswer:
    """Hold back the first answer, from now on, to a request that matches; later ones pass."""
    held = HeldAnswer(page)

    def take(route: "Route") -> None:
        if held.taken:
            route.continue_()
        else:
            held.taken.append((route, route.fetch()))

    page.route(pattern, take)
    return held
