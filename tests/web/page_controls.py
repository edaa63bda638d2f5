"""A page that is not seen: behind another tab, or its window put away; headless browsers never do that themselves."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page

HIDDEN = """(hidden) => {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""


def hide(page: "Page", *, hidden: bool = True) -> None:
    page.evaluate(HIDDEN, hidden)
