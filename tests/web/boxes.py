"""Where things are drawn, all measured in one breath: the page may draw itself anew between two questions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page

Box = dict[str, float]

MEASURED = "(names) => names.map((name) => document.querySelector(name).getBoundingClientRect().toJSON())"


def boxes(page: "Page", *selectors: str) -> Sequence[Box]:
    """Of the first that each selector fits: `x`, `y`, `width`, `height`, pixels from the window's upper left."""
    measured: Sequence[Box] = page.evaluate(MEASURED, selectors)
    return measured
