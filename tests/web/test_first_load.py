"""What the page fetches of its own files before anything is chosen on it, and what it fetches later."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlparse

import pytest

from tests.web.fake_api import STATIC, TOKEN, add_console, create_app, served
from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Browser, Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
WITHOUT_GOALS_BYTES = 92_000
WITH_A_PLAN_BYTES = 150_000
WITH_A_MISSION_BYTES = 146_000
"""Of the console's own files, uncompressed; plan and mission: those of the newest goal, shown as a page opens."""
A_WHILE_MS = 500
"""Longer than a page waits before it fetches what it shows."""


@contextmanager
def first_load(browser: Browser, service: FakeService) -> Iterator[tuple[Page, set[str]]]:
    """The page as it opens, and the console's files that it has fetched, growing."""
    app, fetched = create_app(service), set[str]()
    add_console(app)
    with served(app, service) as address:
        page = browser.new_page()
        page.on(
            "request", lambda request: fetched.add(urlparse(request.url).path.lstrip("/") or "index.html")
        )
        page.goto(f"{address}/?token={TOKEN}")
        expect(page.get_by_test_id("live-badge")).to_have_text("live")
        yield page, fetched
        page.close()


def size(fetched: set[str]) -> int:
    files = [STATIC / name for name in fetched if (STATIC / name).is_file()]
    assert len(files) > 20
    return sum(file.stat().st_size for file in files)


def test_a_first_load_without_goals_fetches_no_more_than_its_budget(
    browser: Browser, service: FakeService
) -> None:
    with first_load(browser, service) as (page, fetched):
        expect(page.get_by_test_id("invitation")).to_be_visible()
        page.wait_for_timeout(A_WHILE_MS)
        assert size(fetched) <= WITHOUT_GOALS_BYTES
        assert not [
            name for name in fetched if re.match(r"plan|mission|replay|speech|workbench/workbench", name)
        ]


@pytest.mark.parametrize(
    ("state", "budget"), [("proposed", WITH_A_PLAN_BYTES), ("approved", WITH_A_MISSION_BYTES)]
)
def test_a_first_load_with_a_plan_fetches_no_more_than_its_budget(
    browser: Browser, service: FakeService, state: str, budget: int
) -> None:
    service.propose("move sample_1 to bay_1")
    if state == "approved":
        service.approve("plan-1")
    with first_load(browser, service) as (page, fetched):
        expect(page.get_by_test_id("plan-state")).to_have_text(state)
        expect(page.get_by_test_id("mission")).to_have_count(1 if state == "approved" else 0)
        page.wait_for_timeout(A_WHILE_MS)
        assert size(fetched) <= budget
        assert not [name for name in fetched if re.match(r"replay|speech|workbench/workbench", name)]


LOST = re.compile(r"\.(js|css)$")
NOT_FETCHED = "This part of the page could not be fetched. Try again once the page is live, or reload it."


@pytest.fixture
def cut_off(page: Page, service: FakeService) -> Page:
    """A page with a plan and a past mission that can fetch nothing more of itself."""
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.complete("mission-1")
    service.propose("move sample_2 to bay_3")
    expect(page.get_by_test_id("goal-item")).to_have_count(2)
    page.get_by_test_id("goal-item").first.click()
    expect(page.get_by_test_id("plan-approve")).to_be_visible()
    page.route(LOST, lambda route: route.abort())
    return page


def test_a_plan_is_confirmed_once_its_dialog_can_be_fetched(cut_off: Page, service: FakeService) -> None:
    cut_off.get_by_test_id("plan-approve").click()
    expect(cut_off.get_by_test_id("plan")).to_contain_text(NOT_FETCHED)
    cut_off.unroute_all()
    cut_off.get_by_test_id("plan-approve").click()
    expect(cut_off.get_by_test_id("plan-dialog")).to_be_visible()
    expect(cut_off.get_by_test_id("plan")).not_to_contain_text(NOT_FETCHED)


def test_what_a_plan_says_when_it_is_opened_is_fetched_at_the_next_opening(cut_off: Page) -> None:
    robots = cut_off.get_by_test_id("robots")
    for _ in range(2):
        robots.locator("summary").click()
        expect(robots).to_contain_text(NOT_FETCHED)
        robots.locator("summary").click()
    cut_off.unroute_all()
    robots.locator("summary").click()
    expect(robots).not_to_contain_text(NOT_FETCHED)


def test_the_workbench_says_that_it_cannot_be_fetched_and_leaves_the_plan(cut_off: Page) -> None:
    bench, button = cut_off.get_by_test_id("workbench"), cut_off.locator("#workbench-toggle")
    button.click()
    expect(bench).to_have_text("The service cannot be reached" + NOT_FETCHED)
    expect(cut_off.get_by_test_id("plan")).to_be_visible()
    button.click()
    expect(bench).to_be_hidden()
    cut_off.unroute_all()
    button.click()
    expect(bench.get_by_role("table")).to_be_visible()
    expect(cut_off.get_by_test_id("plan")).to_be_hidden()
    cut_off.route(LOST, lambda route: route.abort())
    cut_off.get_by_test_id("bench-drive").click()
    expect(bench).to_contain_text(NOT_FETCHED)
    cut_off.unroute_all()
    cut_off.get_by_test_id("bench-drive").click()
    expect(cut_off.get_by_test_id("drive-take")).to_be_visible()


def test_robot_map_and_recording_say_that_they_cannot_be_fetched(cut_off: Page) -> None:
    world, mission = cut_off.locator("#right"), cut_off.get_by_test_id("mission")
    robot, as_map = cut_off.get_by_test_id("robot").first, cut_off.get_by_role("button", name="Map")
    cut_off.get_by_test_id("goal-item").last.click()
    robot.click()
    expect(world).to_contain_text(NOT_FETCHED)
    robot.click()
    expect(world).not_to_contain_text(NOT_FETCHED)
    as_map.click()
    expect(world).to_contain_text(NOT_FETCHED)
    cut_off.get_by_test_id("mission-replay").click()
    expect(mission).to_contain_text(NOT_FETCHED)
    cut_off.unroute_all()
    robot.click()
    expect(cut_off.get_by_test_id("robot-panel")).to_be_visible()
    as_map.click()
    expect(cut_off.get_by_test_id("map")).to_be_visible()
    expect(world).not_to_contain_text(NOT_FETCHED)
    cut_off.get_by_test_id("mission-replay").click()
    expect(cut_off.get_by_test_id("replay-play")).to_be_visible()
    expect(mission).not_to_contain_text(NOT_FETCHED)


WATCH_MIDDLE = """() => {
  window.seen_ = [];
  const bench = document.getElementById("workbench");
  const plan = document.querySelector("[data-testid=plan]");
  const note = () => {
    window.seen_.push([bench.checkVisibility() && bench.querySelector("table") !== null, plan.checkVisibility()]);
    requestAnimationFrame(note);
  };
  note();
}"""
"""In each frame: whether the workbench with its table is seen, and whether the plan is."""


def test_parts_that_come_move_nothing_that_was_there(page: Page, service: FakeService) -> None:
    """The workbench replaces the plan in one frame, though its modules and its style come later."""
    service.propose("move sample_1 to bay_1")
    expect(page.get_by_test_id("plan")).to_be_visible()
    page.evaluate(WATCH_MIDDLE)
    page.locator("#workbench-toggle").click()
    expect(page.get_by_test_id("workbench").get_by_role("table")).to_be_visible()
    before, *others = page.evaluate("window.seen_")
    assert before == [False, True]
    assert {tuple(one) for one in others} <= {(False, True), (True, False)}
