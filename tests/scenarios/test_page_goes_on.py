"""The service is killed under an open page and started again: the page says so, and goes on without a reload."""

from pathlib import Path

import httpx2
from playwright.sync_api import Page, WebSocket, expect, sync_playwright

from tests.chromium import NEEDED, SOFTWARE_GL, chromium
from tests.ports import free_port
from tests.scenarios.killing import kill_family
from tests.scenarios.serving import macta_serve

pytestmark = NEEDED
BACK_MS = 90_000


def talking(page: Page) -> set[WebSocket]:
    """The sockets of the view in three dimensions that have brought something, from now on."""
    heard: set[WebSocket] = set()
    page.on("websocket", lambda socket: socket.on("framereceived", lambda _: heard.add(socket)))
    return heard


def until_more(page: Page, heard: set[WebSocket], than: int) -> None:
    for _ in range(BACK_MS // 200):
        if len(heard) > than:
            return
        page.wait_for_timeout(200)
    raise AssertionError(f"no socket but the {than} before brought anything")


def test_a_page_goes_on_when_the_service_was_killed_and_is_back(tmp_path: Path) -> None:
    data, port = tmp_path / "data", ("--port", str(free_port()))
    with sync_playwright() as driver, chromium(driver, *SOFTWARE_GL) as browser:
        page = browser.new_page()
        live, heard = page.get_by_test_id("live-badge"), talking(page)
        with macta_serve(data, *port) as first:
            page.goto(first.console)
            expect(live).to_have_text("live")
            until_more(page, heard, than=0)
            page.get_by_test_id("goal-text").fill("move sample_1 to")  # what is being written stays
            kill_family(first.process.pid)
            first.process.wait()
        # As below, the view is being built in the page's thread meanwhile.
        expect(live).to_have_text("not live", timeout=BACK_MS)
        before = len(heard)
        with macta_serve(data, *port) as second:
            expect(live).to_have_text("live", timeout=BACK_MS)
            until_more(page, heard, than=before)
            bearer = {"authorization": f"Bearer {second.token}"}
            goal = {"text": "move sample_2 to bay_3"}
            httpx2.post(f"{second.address}/v1/goals", json=goal, headers=bearer).raise_for_status()
            # The view is being built in the page's thread meanwhile, which takes long on a busy machine.
            expect(page.get_by_test_id("goal-item")).to_contain_text(goal["text"], timeout=BACK_MS)
            expect(page.get_by_test_id("goal-text")).to_have_value("move sample_1 to")
