"""An operator approves a plan on the page and sees the mission complete, in a real browser on the real service."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, expect, sync_playwright

from tests.chromium import NEEDED, SOFTWARE_GL, chromium
from tests.scenarios.serving import Served, macta_serve

pytestmark = NEEDED
MISSION_MS = 120_000
PICTURES = os.environ.get("MACTA_PICTURES", "")
SPEED = "1" if PICTURES else "8"


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Served]:
    with macta_serve(tmp_path / "data", "--speed", SPEED) as served:
        yield served


@pytest.fixture
def browser() -> Iterator[Browser]:
    with sync_playwright() as driver, chromium(driver, *SOFTWARE_GL) as browser:
        yield browser


def told(line: ConsoleMessage) -> str:
    return f"{line.text} ({line.location['url']})"


def is_outside(url: str) -> bool:
    return not url.startswith(("http://127.0.0.1:", "blob:", "data:"))


def picture(page: Page, name: str) -> None:
    """Keep pictures of the page, dark and light, where MACTA_PICTURES says; the documentation's are made so."""
    for theme in ("dark", "light") if PICTURES else ():
        page.locator("#theme").select_option(theme)
        page.wait_for_timeout(5000)  # the view of the world draws in its own time, again for another theme
        notice = page.frame_locator("iframe").locator(".mantine-Notification-closeButton")
        if notice.count() and notice.first.is_visible():
            notice.first.click()  # viser warns of software WebGL, which is all a test machine has
            page.wait_for_timeout(500)
        page.screenshot(path=Path(PICTURES) / f"{name}-{theme}.png")


def kept_replay(service: Served, folder: Path) -> Path:
    """The only mission's replay as one file, for a browser without the service."""
    bearer = {"authorization": f"Bearer {service.token}"}
    with httpx2.Client(base_url=service.address, headers=bearer) as api:
        (mission,) = api.get("/v1/missions").json()["items"]
        file = folder / "replay.html"
        file.write_bytes(api.get(f"/v1/missions/{mission['id']}/replay.html").raise_for_status().content)
    return file


def show_carrying(page: Page) -> str:
    """Scrub to a time, in seconds, at which a robot carries a sample: how soon one does depends on the machine."""
    slider = page.get_by_test_id("replay-time")
    for time_s in map(str, range(0, int(float(slider.get_attribute("max") or 0)) + 1, 2)):
        slider.fill(time_s)
        if page.locator(".robot-mark .held").count():
            return time_s
    raise AssertionError("no robot carries anything in the recording")


def test_an_operator_approves_a_plan_on_the_page_and_sees_the_mission_complete(
    service: Served, browser: Browser, tmp_path: Path
) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 810})
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda line: complaints.append(told(line)) if line.type == "error" else None)
    page.on("request", lambda request: complaints.append(request.url) if is_outside(request.url) else None)
    page.goto(service.console)
    expect(page.get_by_test_id("live-badge")).to_have_text("live")

    page.get_by_test_id("goal-text").fill("move sample_1 to bay_7")
    page.get_by_test_id("goal-submit").click()
    # The view in three dimensions is being built in the page's thread meanwhile.
    expect(page.get_by_test_id("plan-approve")).to_be_visible(timeout=MISSION_MS)
    picture(page, "review")

    page.get_by_test_id("plan-approve").click()
    page.get_by_test_id("plan-confirm").click()
    expect(page.get_by_test_id("mission-state")).to_contain_text(re.compile("running|completed"))
    picture(page, "mission")
    expect(page.get_by_test_id("mission-state")).to_contain_text("completed", timeout=MISSION_MS)

    page.get_by_test_id("mission-replay").click()
    expect(page.locator(".robot-mark")).to_have_count(4)
    expect(page.locator(".events")).to_contain_text("mission: running")
    carrying_s = show_carrying(page)
    expect(page.locator(".robot-mark .held")).to_have_count(1)
    picture(page, "replay")
    assert complaints == []

    kept = browser.new_page()
    asked: list[str] = []
    kept.on("request", lambda request: asked.append(request.url.partition(":")[0]))
    kept.goto(kept_replay(service, tmp_path).as_uri())
    kept.get_by_test_id("replay-time").fill(carrying_s)
    expect(kept.locator(".robot-mark .held")).to_have_count(1)
    assert set(asked) <= {"file", "data"}
