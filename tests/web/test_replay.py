"""Replaying a past mission on the console."""

from pathlib import Path
from typing import Any

import pytest

from app.recordings.replay_page import replay_page
from tests.web.fake_api import STATIC
from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Browser, Locator, Page, expect  # noqa: E402

pytestmark = pytest.mark.browser


@pytest.fixture
def past(page: Page, service: FakeService) -> Page:
    """A mission of the past, its recording opened."""
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.complete("mission-1")
    page.get_by_test_id("mission-replay").click()
    expect(page.locator(".robot-mark")).to_have_count(1)
    return page


def scrub(page: Page, time_s: float) -> None:
    page.get_by_test_id("replay-time").fill(str(time_s))


def happened(page: Page) -> Locator:
    """The event that the cursor is at."""
    return page.locator(".events [aria-current]")


def test_a_recording_is_scrubbed_and_shows_what_was(past: Page) -> None:
    drawn = past.locator(".robot-mark > g")
    for time_s, x_m in ((0, 1), (20, 3), (30, 4), (10, 2)):
        scrub(past, time_s)
        expect(drawn).to_have_attribute("transform", f"translate({x_m} -2) rotate(0)")
    samples = past.locator(".sample-mark[data-name=sample_1]")
    for time_s, count in ((5, 1), (15, 0), (25, 1)):
        scrub(past, time_s)
        expect(samples).to_have_count(count)
    expect(past.get_by_test_id("replay-clock")).to_have_text("25.0 s of 40.0 s")
    expect(happened(past)).to_contain_text("20.0 s world: facts changed")
    scrub(past, 40)
    expect(happened(past)).to_contain_text("mission: completed")
    expect(past.locator(".actual.finished")).to_have_count(8)


def test_the_worlds_robots_are_drawn_from_the_start_and_others_once_they_have_come(
    page: Page, service: FakeService, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = service.replay

    def heard_later(mission_id: str) -> dict[str, Any]:
        replay = recorded(mission_id)
        later_s = replay["missions"][0]["at_s"] + 10
        first = [[later_s, 2.0, 3.0, 0.0, None, None]]
        return replay | {"robots": replay["robots"] | {"store_1": first, "visitor_1": first}}

    monkeypatch.setattr(service, "replay", heard_later)
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.complete("mission-1")
    page.get_by_test_id("mission-replay").click()
    expect(page.locator(".robot-mark")).to_have_count(2)
    expect(page.locator(".robot-mark[data-robot=store_1] > g")).to_have_attribute(
        "transform", "translate(2 -3) rotate(0)"
    )
    scrub(page, 9)
    expect(page.locator(".robot-mark")).to_have_count(2)
    scrub(page, 10)
    expect(page.locator(".robot-mark")).to_have_count(3)


def test_a_recording_is_played_to_its_end_at_fifty_times_the_speed(past: Page) -> None:
    past.get_by_label("Speed").select_option("50")
    past.get_by_test_id("replay-play").click()
    expect(past.get_by_test_id("replay-clock")).to_have_text("40.0 s of 40.0 s")
    expect(past.get_by_test_id("replay-play")).to_have_text("Play")


def test_a_recording_is_gone_through_by_the_keyboard_alone(past: Page) -> None:
    clock = past.get_by_test_id("replay-clock")
    past.get_by_test_id("replay-time").focus()
    for key, time in (
        ("ArrowRight", "1.0 s"),
        ("PageDown", "10.0 s"),
        ("PageDown", "20.0 s"),
        ("PageUp", "10.0 s"),
    ):
        past.keyboard.press(key)
        expect(clock).to_have_text(f"{time} of 40.0 s")
    past.keyboard.press(" ")
    expect(past.get_by_test_id("replay-play")).to_have_text("Pause")
    past.keyboard.press(" ")
    expect(past.get_by_test_id("replay-play")).to_have_text("Play")


def test_events_are_listed_in_step_with_the_cursor_and_lead_to_their_instant(past: Page) -> None:
    events = past.locator(".events li")
    expect(events).to_have_count(4)
    expect(events.first).to_have_text("−5.0 s plan: approved administrator")
    expect(happened(past)).to_contain_text("plan: approved")  # before it began
    events.nth(2).get_by_role("button").click()
    expect(past.get_by_test_id("replay-clock")).to_have_text("20.0 s of 40.0 s")
    expect(happened(past)).to_have_count(1)
    past.keyboard.press("ArrowDown")
    expect(happened(past)).to_contain_text("mission: completed")
    expect(past.get_by_test_id("replay-clock")).to_have_text("39.0 s of 40.0 s")
    past.get_by_label("Event before").click()
    expect(happened(past)).to_contain_text("20.0 s world: facts changed")


def test_a_robots_recorded_telemetry_stands_in_its_panel(past: Page, service: FakeService) -> None:
    scrub(past, 5)
    past.locator(".robot-mark").click()  # the recording stands still
    expect(past.get_by_test_id("robot-panel")).to_contain_text("80 %")
    scrub(past, 25)
    expect(past.get_by_test_id("robot-panel")).to_contain_text("60 %")
    past.get_by_test_id("replay-close").click()
    expect(past.get_by_test_id("robot-panel")).to_contain_text("97 %")


def test_what_is_comes_back_when_the_recording_is_closed(past: Page, service: FakeService) -> None:
    service.telemetry["yard_1"]["x_m"] = 7.5
    scrub(past, 20)
    expect(past.locator(".robot-mark")).to_have_count(1)
    past.get_by_test_id("replay-close").click()
    expect(past.get_by_test_id("player")).to_be_hidden()
    expect(past.locator(".robot-mark")).to_have_count(4)
    expect(past.locator(".robot-mark[data-robot=yard_1] > g")).to_have_attribute(
        "transform", "translate(7.5 -1.8) rotate(0)"
    )


def test_a_recording_that_was_kept_as_a_file_plays_without_the_service(
    browser: Browser, service: FakeService, tmp_path: Path
) -> None:
    service.propose("move sample_1 to bay_1", reason="</script><b>")
    service.approve("plan-1")
    service.complete("mission-1")
    replay = service.replay("mission-1") | {"plans": {"plan-1": service.plans["plan-1"]}}
    file = tmp_path / "replay.html"
    file.write_text(replay_page(STATIC, replay, title="mission-1 </title><i>"))
    page = browser.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url.partition(":")[0]))
    page.goto(file.as_uri())
    page.get_by_test_id("replay-time").fill("20")
    expect(page.locator(".robot-mark > g")).to_have_attribute("transform", "translate(3 -2) rotate(0)")
    expect(page.locator("[data-action]")).to_have_count(8)
    assert set(asked) <= {"file", "data"}
    page.close()


def test_a_recordings_results_appear_when_they_came(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.bring("mission-1", "image", "camera")
    service.complete("mission-1")
    page.get_by_test_id("mission-replay").click()
    image = page.locator("#player").get_by_alt_text("bay_1 as the camera of yard_1 sees it")
    scrub(page, 10)
    expect(image).to_have_count(0)
    scrub(page, 20)
    expect(image).to_have_js_property("naturalWidth", 1)
    expect(page.locator("#player figcaption")).to_have_text("bay_1, by yard_1, 15.0 s")
    page.locator("#player figure button").click()
    large = page.get_by_test_id("result-dialog")
    expect(large.get_by_role("img")).to_be_visible()
    page.keyboard.press("Escape")
    expect(large).to_have_count(0)


def thinks(at_s: float, *beliefs: str) -> dict[str, Any]:
    told = [
        {"term": one, "value": True, "origin": "adopted", "source": "guard:2", "words": "", "since_s": at_s}
        for one in beliefs
    ]
    fired = {"rule": "guard:2", "name": "adoptBelief(on_duty)", "towards": "", "bindings": {}, "words": ""}
    commitments = [fired | {"made_s": at_s, "state": "fulfilled", "reason": None}] if beliefs else []
    agent = {"name": "guard", "roles": [], "beliefs": told, "belief_count": len(told)}
    agent |= {"commitments": commitments, "commitment_count": len(commitments)}
    return {"at_s": at_s, "agents": [agent], "conversations": []}


def test_mind_and_messages_are_shown_as_of_the_scrubbed_instant(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    start_s = service.missions["mission-1"]["started_at_s"]
    service.recorded_minds = {"yard_1": [thinks(start_s + 5), thinks(start_s + 20, "on_duty")]}
    service.say("mission-1", "yard_1", "store_1", "ended(mission-1-store_1, a4)", start_s + 18)
    service.complete("mission-1")
    page.get_by_test_id("mission-replay").click()
    minds = page.get_by_test_id("replay-minds")
    minds.locator("summary").click()
    expect(minds).to_contain_text("Nothing of its mind was recorded yet.")
    speech = page.get_by_test_id("replay-speech")
    speech.locator("summary").click()
    expect(speech).to_contain_text("Nothing was said.")
    scrub(page, 10)
    expect(minds).to_contain_text("No rule has fired.")
    scrub(page, 18.1)
    expect(speech.locator("[data-saying]")).to_have_count(1)
    scrub(page, 25)
    expect(minds.get_by_role("row", name="✓ on_duty")).to_contain_text("5.0 s")
    expect(minds).to_contain_text("guard:2")
    expect(speech.locator("[data-saying]")).to_have_count(2)
    scrub(page, 10)
    expect(minds).to_contain_text("No rule has fired.")
    expect(speech).to_contain_text("Nothing was said.")
