"""What moves on the page, and that it does not for those who want little motion (`prefers-reduced-motion`)."""

from typing import Literal

import pytest

from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
Wish = Literal["reduce", "no-preference"]
# In a sheet of its own, as the page's policy takes none that stands in the document.
MOVED = """
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(`
    @keyframes turning { to { rotate: 1turn } }
    .bar, .bar::before { content: ""; animation: turning 9s infinite; transition: opacity 9s; scroll-behavior: smooth }
  `);
  document.adoptedStyleSheets.push(sheet);
  document.querySelector(".bar").getBoundingClientRect();
  document.querySelector(".bar").style.opacity = 0.5;
"""
MOVING = "document.getAnimations().length"
SCROLLS = "getComputedStyle(document.querySelector('.bar')).scrollBehavior"


@pytest.mark.parametrize(
    ("wish", "moving", "scrolls"), [("reduce", 0, "auto"), ("no-preference", 3, "smooth")]
)
def test_whatever_a_style_sets_in_motion_stands_still_for_who_wants_no_motion(
    page: Page, wish: Wish, moving: int, scrolls: str
) -> None:
    page.emulate_media(reduced_motion=wish)
    page.evaluate(MOVED)
    assert (page.evaluate(MOVING), page.evaluate(SCROLLS)) == (moving, scrolls)


def tell(page: Page, service: FakeService, number: int) -> None:
    """A word of yard_1, heard: the metres to what is nearest and its battery are this number of tenths.

    Its panel and its charts hear each word in the same breath, and the panel shows it at once.
    """
    said = {"at_s": 30.0 - number, "ranges_m": [number / 10], "battery": number / 10}
    service.telemetry["yard_1"] = service.telemetry["yard_1"] | said
    expect(page.get_by_test_id("robot-panel")).to_contain_text(f"{number}0 %")


@pytest.mark.parametrize("wish", ["reduce", "no-preference"])
def test_strip_charts_are_drawn_once_a_second_for_who_wants_no_motion(
    page: Page, service: FakeService, wish: Wish
) -> None:
    page.emulate_media(reduced_motion=wish)
    page.locator("[data-testid=robot][data-robot=yard_1]").click()
    page.locator("#workbench-toggle").click()
    page.get_by_test_id("bench-plots").click()
    nearest = page.locator(".charts figure").nth(2)
    expect(nearest).to_contain_text("yard_1 1.20")
    page.evaluate("window.now_ = performance.now(); performance.now = () => window.now_")
    tell(page, service, 9)
    page.evaluate("window.now_ += 2000")
    expect(nearest).to_contain_text("yard_1 0.90")
    tell(page, service, 8)
    page.evaluate("window.now_ += 900")
    tell(page, service, 7)
    assert ("yard_1 0.90" in nearest.inner_text()) == (wish == "reduce")
    page.evaluate("window.now_ += 900")
    expect(nearest).to_contain_text("yard_1 0.70")
