"""The console's frame: panes, themes, what asks for a decision, long lists; usable by everyone."""

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from tests.web.fake_service import FakeService
from tests.web.page_controls import hide

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
SIZES = [(1280, 720), (1920, 1080), (800, 1100)]


def width(page: Page, name: str) -> float:
    box = page.locator(name).bounding_box()
    assert box is not None
    return box["width"]


def test_panes_are_resized_by_pointer_and_keyboard_and_stay_so(page: Page) -> None:
    before = width(page, "#left")
    box = page.locator("#left-divider").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 3, 300)
    page.mouse.down()
    page.mouse.move(box["x"] + 63, 300)
    page.mouse.up()
    assert width(page, "#left") == pytest.approx(before + 60, abs=4)
    page.locator("#right-divider").focus()
    right = width(page, "#right")
    page.keyboard.press("ArrowLeft")
    assert width(page, "#right") == pytest.approx(right + 24, abs=1)
    page.reload()
    assert width(page, "#left") == pytest.approx(before + 60, abs=4)


def test_panes_are_put_away_and_come_back(page: Page) -> None:
    middle = width(page, "#middle")
    page.locator("#right-toggle").click()
    expect(page.locator("#right")).to_be_hidden()
    assert width(page, "#middle") > middle * 1.5
    page.locator("#right-toggle").click()
    expect(page.locator("#right")).to_be_visible()
    assert width(page, "#middle") == pytest.approx(middle, abs=2)


@pytest.mark.parametrize("size", SIZES)
def test_nothing_hangs_over_the_pages_edge(page: Page, service: FakeService, size: tuple[int, int]) -> None:
    service.propose("move sample_1 to bay_1")
    page.set_viewport_size({"width": size[0], "height": size[1]})
    expect(page.get_by_test_id("plan")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]


def test_a_plan_that_waits_elsewhere_asks_for_its_decision(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    expect(page.get_by_test_id("plan")).to_be_visible()
    service.propose("move sample_2 to bay_3")
    alert = page.get_by_test_id("alert")
    expect(alert).to_contain_text("A plan waits for your decision: move sample_2 to bay_3")
    alert.get_by_role("button", name="Review").click()
    expect(page.locator("#goal h2")).to_have_text("move sample_2 to bay_3")


def test_a_stuck_mission_asks_for_a_decision_and_takes_it(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.missions["mission-1"]["recovery"] = {"step": "stuck", "attempts": [], "policy": "ask"}
    service.publish("mission.recovering", "mission-1")
    alert = page.get_by_test_id("alert")
    expect(alert).to_contain_text("no repair was found")
    alert.get_by_role("button", name="Cancel").click()
    expect(page.get_by_test_id("mission-state")).to_have_text("cancelled")


def test_an_answer_that_is_refused_says_why(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.missions["mission-1"]["recovery"] = {"step": "stuck", "attempts": [], "policy": "ask"}
    service.refusal = "mission mission-1 has ended meanwhile"
    service.publish("mission.recovering", "mission-1")
    page.get_by_test_id("alert").get_by_role("button", name="Try again").click()
    expect(page.locator("#alerts").get_by_role("alert")).to_contain_text("has ended meanwhile")
    expect(page.get_by_test_id("alert").get_by_role("button", name="Try again")).to_be_enabled()


def test_a_goal_that_is_looked_at_stays_when_fifty_newer_ones_come(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    page.get_by_test_id("goal-item").click()
    for _ in range(60):
        service.propose("move sample_2 to bay_3", state="finished", outcome="completed")
    service.plans["plan-1"] |= {"comment": "a late word", "state": "rejected"}
    service.publish("plan.rejected", "plan-1")
    expect(page.get_by_test_id("plan-decided")).to_contain_text("a late word")
    expect(page.locator("#goal h2")).to_have_text("move sample_1 to bay_1")
    del service.goals["goal-1"]
    service.publish("goal.finished", "goal-2")
    expect(page.locator("#goal h2")).to_have_text("move sample_2 to bay_3")


A_WHILE_MS = 1000
"""Longer than a page that is seen waits with asking for what it was told of."""


def test_a_page_that_nobody_sees_asks_only_once_it_is_seen_again(page: Page, service: FakeService) -> None:
    expect(page.get_by_test_id("invitation")).to_be_visible()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    hide(page)
    service.propose("move sample_1 to bay_1")
    page.wait_for_timeout(A_WHILE_MS)
    assert not [url for url in asked if url.endswith("/v1/goals/goal-1")]
    hide(page, hidden=False)
    expect(page.get_by_test_id("goal-item")).to_have_count(1)


def test_a_page_without_goals_shows_the_first_steps(page: Page, service: FakeService) -> None:
    page.get_by_test_id("invitation").get_by_role("button", name="State a goal").click()
    expect(page.get_by_test_id("goal-text")).to_be_focused()
    service.propose("move sample_1 to bay_1")
    expect(page.get_by_test_id("invitation")).to_have_count(0)


def test_a_long_list_is_shown_a_page_at_a_time(page: Page, service: FakeService) -> None:
    for _ in range(120):
        service.propose("move sample_1 to bay_1", state="finished", outcome="completed")
    expect(page.get_by_test_id("goal-item")).to_have_count(50)
    page.locator("#goals").get_by_role("button", name="Show older").click()
    expect(page.get_by_test_id("goal-item")).to_have_count(100)


def asked(page: Page, _: FakeService) -> None:
    page.get_by_test_id("plan-approve").click()
    expect(page.get_by_test_id("plan-dialog")).to_be_visible()


def typing(page: Page, _: FakeService) -> None:
    page.get_by_test_id("goal-text").press_sequentially("move")
    expect(page.locator("#goal-offers li").first).to_be_visible()


def table(page: Page, _: FakeService) -> None:
    page.get_by_test_id("plan-as-table").click()
    expect(page.get_by_test_id("action-table")).to_be_visible()


def mapped(page: Page, _: FakeService) -> None:
    page.get_by_role("button", name="Map").click()
    page.locator(".robot-mark[data-robot=yard_1] circle").click()
    expect(page.get_by_test_id("robot-panel")).to_contain_text("yard_1")


def followed(page: Page, _: FakeService) -> None:
    """In three dimensions, with the legend open."""
    page.get_by_test_id("robot").first.click()
    page.locator("#follow").click()
    page.locator("#legend summary").click()
    expect(page.locator("#legend li").first).to_be_visible()


def bench(page: Page, service: FakeService, state: str) -> None:
    service.approve("plan-1")
    service.navigate("store_1", "mission-1")
    page.get_by_test_id("robot").first.click()
    page.locator("#workbench-toggle").click()
    page.get_by_test_id(state).click()
    if state == "bench-drive":
        page.get_by_test_id("drive-take").click()
        expect(page.get_by_test_id("drive-state")).to_contain_text("You drive")
    if state in ("bench-plots", "bench-behaviour"):
        expect(page.locator(".strip").first).to_be_visible()


def replay(page: Page, service: FakeService) -> None:
    service.approve("plan-1")
    service.complete("mission-1")
    page.get_by_test_id("mission-replay").click()
    expect(page.locator(".robot-mark")).to_have_count(1)


def choices(page: Page, _: FakeService) -> None:
    page.get_by_test_id("seek-alternatives").click()
    expect(page.get_by_test_id("alternatives")).to_be_visible()


def planning(page: Page, service: FakeService) -> None:
    service.plan_on("goal-1", makespan_s=110.0, lower_bound_s=100.0, elapsed_s=2.5)
    expect(page.get_by_test_id("planning").get_by_role("img")).to_be_visible()


def repaired(page: Page, service: FakeService) -> None:
    service.approve("plan-1")
    service.ask_about_repair("mission-1")
    service.plans["plan-1-repaired"]["overtaken"] = ["in(sample_1, door_1) is no longer true"]
    service.publish("plan.proposed", "plan-1-repaired")
    expect(page.locator(".ghost.dropped").first).to_be_attached()
    expect(page.get_by_test_id("overtaken")).to_be_visible()


def unknown(page: Page, service: FakeService) -> None:
    service.approve("plan-1")
    service.missions["mission-1"] |= {"state": "unknown", "reason": "yard_1 does not answer"}
    service.telemetry["yard_2"]["battery"] = 0.1
    silence = {"silent": True, "connection": "offline", "heard_at_s": 2.0, "mission_id": "mission-1"}
    service.hearing = {"yard_1": silence, "store_1": silence | {"silent": False}}
    service.publish("mission.unknown", "mission-1")
    expect(page.locator(".unheard")).to_have_count(2)


def running(page: Page, service: FakeService) -> None:
    service.approve("plan-1")
    service.propose("move sample_2 to bay_3")
    expect(page.get_by_test_id("mission-state")).to_have_text("running")
    expect(page.get_by_test_id("alert")).to_be_visible()


STATES: dict[str, Callable[[Page, FakeService], None]] = {
    "proposed": lambda _page, _service: None,
    "asked": asked,
    "typing": typing,
    "table": table,
    "map": mapped,
    "followed": followed,
    "choices": choices,
    "planning": planning,
    "running": running,
    "repaired": repaired,
    "unknown": unknown,
    "replay": replay,
    **{
        name: partial(bench, state=name)
        for name in ("bench-robots", "bench-drive", "bench-plots", "bench-behaviour")
    },
}
"""What is done on the page, or befalls it, once a plan is proposed."""


@pytest.mark.parametrize("state", ["empty", *STATES])
def test_nothing_keeps_anyone_from_using_the_page(page: Page, service: FakeService, state: str) -> None:
    """Axe-core's rules, with those of WCAG 2.2 AA: names, roles, contrast, reach. In the dark only colours differ."""
    page.locator("#theme").select_option("light")
    if state != "empty":
        service.propose("move sample_1 to bay_1")
        expect(page.get_by_test_id("plan")).to_be_visible()
        STATES[state](page, service)
    assert violations(page) == []
    # What is open stays so: the choice is made without the focus.
    page.locator("#theme").evaluate(
        "list => { list.value = 'dark'; list.dispatchEvent(new Event('change')); }"
    )
    assert page.locator("html").get_attribute("data-theme") == "dark"
    assert violations(page, runOnly=["color-contrast"]) == []


def violations(page: Page, **options: Any) -> list[tuple[str, list[str]]]:
    """The rules that are not kept, and where."""
    found = axe.Axe().run(page, options={"resultTypes": ["violations"], **options}).response
    return [(rule["id"], [node["html"] for node in rule["nodes"]]) for rule in found["violations"]]
