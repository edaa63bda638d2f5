"""A real browser before the fake service."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.chromium import PROGRAM, SOFTWARE_GL, chromium
from tests.web.fake_api import TOKEN, add_console, create_app, served
from tests.web.fake_service import FakeService

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Playwright


@pytest.fixture(scope="package")
def playwright_driver() -> Iterator["Playwright"]:
    """One for all tests of the console: not longer, for code beside it cannot run an event loop of its own."""
    playwright = pytest.importorskip("playwright.sync_api")
    if PROGRAM is None:
        pytest.skip("no chromium on this machine")
    with playwright.sync_playwright() as driver:
        yield driver


@pytest.fixture(scope="package")
def browser(playwright_driver: "Playwright") -> Iterator["Browser"]:
    """Without WebGL."""
    with chromium(playwright_driver, "--disable-gpu") as running:
        yield running


@pytest.fixture(scope="package")
def webgl_browser(playwright_driver: "Playwright") -> Iterator["Browser"]:
    """With WebGL drawn in software."""
    with chromium(playwright_driver, *SOFTWARE_GL) as running:
        yield running


@pytest.fixture
def service() -> FakeService:
    return FakeService()


@pytest.fixture
def page(browser: "Browser", service: FakeService) -> Iterator["Page"]:
    """The console, live; it must not complain."""
    from playwright.sync_api import expect

    app = create_app(service)
    add_console(app)
    with served(app, service) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        complaints: list[str] = []
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda line: complaints.append(line.text) if "Policy" in line.text else None)
        page.goto(f"{address}/?token={TOKEN}")
        expect(page.get_by_test_id("live-badge")).to_have_text("live")
        yield page
        page.close()
        assert complaints == []
