"""An operator approves a plan on the page and sees the mission complete, in a real browser on the real service."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from tests.scenarios.serving import Served, macta_serve

CHROMIUM = shutil.which("chromium")
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine: apt-get install chromium"),
]
FLAGS = [
    "--no-sandbox",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
PLAN_MS = 20_000
MISSION_MS = 120_000


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Served]:
    with macta_serve(tmp_path / "data", "--speed", "6") as served:
        yield served


@pytest.fixture
def browser() -> Iterator[Browser]:
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield chromium
        chromium.close()


def picture(page: Page, name: str) -> None:
    """Keep a picture of the page where MACTA_PICTURES says; the documentation's are made so."""
    folder = os.environ.get("MACTA_PICTURES")
    if folder:
        page.wait_for_timeout(1500)  # the view of the world draws in its own time
        notice = page.frame_locator("iframe").locator(".mantine-Notification-closeButton")
        if notice.count():
            notice.first.click()  # viser warns of software WebGL, which is all a test machine has
            page.wait_for_timeout(500)
        page.screenshot(path=Path(folder) / name)


def test_an_operator_approves_a_plan_on_the_page_and_sees_the_mission_complete(
    service: Served, browser: Browser
) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 810})
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(service.console)
    expect(page.get_by_test_id("live-badge")).to_have_text("live")

    page.get_by_test_id("goal-text").fill("move sample_1 to bay_7")
    page.get_by_test_id("goal-submit").click()
    expect(page.get_by_test_id("plan-approve")).to_be_visible(timeout=PLAN_MS)
    picture(page, "console.png")

    page.get_by_test_id("plan-approve").click()
    expect(page.get_by_test_id("mission-state")).to_contain_text("running", timeout=PLAN_MS)
    picture(page, "mission.png")
    expect(page.get_by_test_id("mission-state")).to_contain_text("completed", timeout=MISSION_MS)
    assert complaints == []
