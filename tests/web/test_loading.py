"""The console follows events and asks only for what they changed."""

import pytest

from tests.web.fake_service import FakeService
from tests.web.page_controls import hold_first

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
HOLDS = "/v1/worlds/sample_store/holds"
CLOCK = ("/v1/worlds", "/v1/robots", "/v1/peripherals", "/v1/view")


def asked_of(page: Page) -> list[str]:
    """Paths that the page asks for from now on, but for those that it asks for as time goes by."""
    asked: list[str] = []
    page.on("request", lambda request: asked.append("/" + request.url.split("/", 3)[3]))
    return asked


def until_all_is_asked(page: Page, service: FakeService) -> None:
    """Wait until the page has asked for what it was told of before: its loads follow each other."""
    with page.expect_response(f"**{HOLDS}"):
        service.publish("hold.began", "hold-1")


def test_only_what_an_event_is_about_is_asked_for(page: Page, service: FakeService) -> None:
    for _ in range(60):
        service.propose("move sample_1 to bay_1", state="finished", outcome="completed")
    service.approve("plan-60")
    newest = page.get_by_test_id("goal-item").first
    expect(newest).to_contain_text("committed")
    newest.click()  # the page may have selected one of those before, if it asked while they were stated
    expect(page.get_by_test_id("mission-state")).to_have_text("running")
    until_all_is_asked(page, service)
    asked = asked_of(page)
    service.missions["mission-60"]["state"] = "paused"
    service.publish("mission.paused", "mission-60")
    expect(page.get_by_test_id("mission-state")).to_have_text("paused")
    service.publish("packet.finished", "mission-60")
    service.publish("script.status", "mission-60-yard_1")
    until_all_is_asked(page, service)
    assert {one for one in asked if one not in CLOCK} == {
        "/v1/missions/mission-60",
        "/v1/goals/goal-60",
        HOLDS,
    }
    asked.clear()
    service.publish("world.facts_changed", "sample_store")
    until_all_is_asked(page, service)
    assert sorted(one for one in asked if one not in CLOCK) == [HOLDS, "/v1/worlds/sample_store/unknown"]


def test_an_answer_that_comes_late_does_not_set_the_worlds_clock_back(
    page: Page, service: FakeService
) -> None:
    held = hold_first(page, "**/v1/worlds")
    held.wait()
    service.time_s += 30.0
    clock = page.locator("#world-time")
    expect(clock).to_have_text("42.0 s")
    held.hand_over()
    assert clock.inner_text() == "42.0 s"


def test_an_older_goals_change_neither_lists_it_nor_hides_it(page: Page, service: FakeService) -> None:
    for _ in range(55):
        service.propose("move sample_1 to bay_1", state="finished", outcome="completed")
    expect(page.get_by_test_id("goal-item")).to_have_count(50)
    service.publish("goal.finished", "goal-1")  # older than those that are listed
    service.goals["goal-54"] |= {"outcome": "failed"}
    service.publish("goal.finished", "goal-54")
    expect(page.get_by_test_id("goal-item").nth(1)).to_contain_text("failed")
    expect(page.get_by_test_id("goal-item")).to_have_count(50)
    service.propose("move sample_2 to bay_3")
    expect(page.get_by_test_id("goal-item").first).to_contain_text("move sample_2 to bay_3")


def test_a_goal_that_was_deleted_leaves_the_list(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.propose("move sample_2 to bay_3")
    expect(page.get_by_test_id("goal-item")).to_have_count(2)
    del service.goals["goal-1"]
    service.publish("goal.deleted", "goal-1")
    expect(page.get_by_test_id("goal-item")).to_have_count(1)
