"""The whole story without a mouse: a goal stated, its plan reviewed and approved, its mission watched and replayed."""

import pytest

from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
FARTHEST = 60
IS_SEEN = """
  const node = document.activeElement;
  getComputedStyle(node).outlineStyle !== "none" || node.classList.contains("looked-at");
"""


def tab_to(page: Page, selector: str) -> None:
    """Go on with the tab key until what was meant has the focus, and can be seen to have it."""
    for _ in range(FARTHEST):
        if page.evaluate("(selector) => document.activeElement?.matches(selector) ?? false", selector):
            assert page.evaluate(IS_SEEN), f"nothing shows that {selector} has the focus"
            return
        page.keyboard.press("Tab")
    raise AssertionError(f"{selector} is not reached with {FARTHEST} tabs")


def test_an_operator_needs_no_mouse(page: Page, service: FakeService) -> None:
    keys = page.keyboard
    tab_to(page, "#goal-text")
    keys.type("move sample_1 to bay_1")
    keys.press("Enter")
    expect(page.get_by_test_id("plan-approve")).to_be_visible()

    tab_to(page, "[data-action]")
    keys.press("ArrowRight")
    expect(page.get_by_test_id("plan")).to_contain_text("yard_1 drives up to sample_1 at door_1")
    keys.press("a")
    expect(page.get_by_test_id("plan-dialog")).to_contain_text("These 2 robots will move")
    keys.press("Escape")
    expect(page.get_by_test_id("plan-dialog")).to_have_count(0)
    assert service.decisions == []
    keys.press("a")
    expect(page.get_by_test_id("plan-dialog")).to_be_visible()
    keys.press("Enter")

    state = page.get_by_test_id("mission-state")
    expect(state).to_have_text("running")
    tab_to(page, "[data-testid=mission-pause]")
    keys.press("Enter")
    expect(state).to_have_text("paused")
    tab_to(page, "[data-testid=mission-resume]")
    keys.press("Enter")
    expect(state).to_have_text("running")
    service.complete("mission-1")
    expect(state).to_have_text("completed")

    tab_to(page, "[data-testid=mission-replay]")
    keys.press("Enter")
    expect(page.get_by_test_id("replay-play")).to_be_focused()
    tab_to(page, "[data-testid=replay-time]")
    keys.press("End")
    expect(page.get_by_test_id("replay-clock")).to_have_text("40.0 s of 40.0 s")
    keys.press("PageUp")
    expect(page.locator(".events [aria-current]")).to_contain_text("facts changed")
    tab_to(page, "[data-testid=replay-close]")
    keys.press("Enter")
    expect(page.get_by_test_id("player")).to_be_hidden()
