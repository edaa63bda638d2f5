"""The sequence diagram of what robots say, in the mission's pane and in the workbench."""

from typing import Any

import pytest

from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
from playwright.sync_api import Locator, Page, Route, expect  # noqa: E402

pytestmark = pytest.mark.browser


def mission(service: FakeService) -> str:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    return "mission-1"


def opened(page: Page, service: FakeService) -> Locator:
    """The messages of a mission in which two robots have spoken."""
    name = mission(service)
    service.say(name, "yard_1", "store_1", "ended(mission-1-store_1, a4)", 13.0)
    service.say(name, "yard_2", "yard_1", "ended(mission-1-yard_1, a9)", 14.0, attempt=3, at_s=20.5)
    panel = page.get_by_test_id("mission-speech")
    panel.locator("summary").click()
    expect(panel.locator("[data-saying]")).to_have_count(4)
    return panel


def test_messages_are_arrows_between_lifelines_in_order_of_time(page: Page, service: FakeService) -> None:
    panel = opened(page, service)
    expect(panel.locator(".lifeline")).to_have_text(["store_1store_1", "yard_1yard_1", "yard_2yard_2"])
    said = panel.locator("[data-saying]")
    expect(said.first).to_have_accessible_name(
        "13.0 s: yard_1 to store_1, inform ended(mission-1-store_1, a4)"
    )
    expect(said.nth(1)).to_have_accessible_name(
        "13.2 s: store_1 to yard_1, confirm ended(mission-1-store_1, a4); whether it was heard is not reported"
    )
    ends = said.first.locator("line").evaluate("(line) => [line.x1.baseVal.value, line.x2.baseVal.value]")
    assert ends[0] > ends[1], "store_1 is left of yard_1"


def test_what_had_to_be_said_again_is_marked(page: Page, service: FakeService) -> None:
    again = opened(page, service).locator(".saying.repeated")
    expect(again).to_have_count(1)
    expect(again).to_contain_text("×3")
    expect(again.locator(".cross")).to_be_attached()
    expect(again).to_have_accessible_name(
        "14.0 s: yard_2 to yard_1, inform ended(mission-1-yard_1, a9); "
        "said 3 times: 2 copies were lost or overtaken, heard 6.5 s later"
    )


def test_a_chosen_message_shows_its_words_and_its_conversation_by_keyboard(
    page: Page, service: FakeService
) -> None:
    panel = opened(page, service)
    panel.locator("[data-saying='3']").focus()
    page.keyboard.press("Home")
    expect(panel.locator("[data-saying='0']")).to_be_focused()
    expect(panel.locator(".saying.faint")).to_have_count(2)
    expect(page.get_by_test_id("speech-words")).to_contain_text("ended(mission-1-store_1, a4)")
    page.keyboard.press("ArrowDown")
    expect(panel.locator("[data-saying='1']")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("Escape")
    expect(panel.locator(".saying.faint")).to_have_count(0)
    expect(page.get_by_test_id("speech-words")).to_be_hidden()


def test_a_focused_message_keeps_the_focus_when_the_mission_reports(page: Page, service: FakeService) -> None:
    panel = opened(page, service)
    panel.locator("[data-saying='0']").focus()
    service.complete("mission-1")
    expect(page.get_by_test_id("mission-state")).to_have_text("completed")
    expect(panel.locator("[data-saying='0']")).to_be_focused()


def test_a_focused_message_keeps_the_focus_when_a_second_answer_arrives(
    page: Page, service: FakeService
) -> None:
    name = mission(service)
    service.say(name, "yard_1", "store_1", "ended(mission-1-store_1, a4)", 13.0)
    held: list[Route] = []
    page.route(
        "**/v1/missions/*/conversation",
        lambda route: held.append(route) if len(held) < 2 else route.continue_(),
    )
    panel = page.get_by_test_id("mission-speech")
    panel.locator("summary").click()
    while len(held) < 1:
        page.wait_for_timeout(10)
    service.publish("mission.running", name)
    while len(held) < 2:
        page.wait_for_timeout(10)
    held[0].continue_()
    panel.locator("[data-saying='0']").focus()
    service.said.append(service.said[0] | {"sender": "yard_2", "conversation": "talk-2", "sent_at_s": 14.0})
    held[1].continue_()
    expect(panel.locator("[data-saying]")).to_have_count(4)
    expect(panel.locator("[data-saying='0']")).to_be_focused()


def test_messages_are_filtered_and_listed_in_a_table(page: Page, service: FakeService) -> None:
    panel = opened(page, service)
    page.get_by_test_id("speech-who").select_option("yard_2")
    expect(panel.locator("[data-saying]")).to_have_count(2)
    page.get_by_test_id("speech-who").select_option("")
    page.get_by_test_id("speech-talk").select_option("talk-1")
    page.get_by_test_id("speech-table").click()
    rows = panel.locator("tbody tr")
    expect(rows).to_have_count(2)
    expect(rows.first).to_contain_text("yard_1store_1informended(mission-1-store_1, a4)macta-inform13.2")


def test_the_missions_messages_follow_and_keep_what_is_looked_at(page: Page, service: FakeService) -> None:
    panel = opened(page, service)
    panel.locator("[data-saying='0']").click()
    service.say("mission-1", "store_1", "yard_2", "ended(mission-1-yard_2, a7)", 24.0)
    expect(panel.locator("[data-saying]")).to_have_count(6)
    expect(panel.locator("[data-saying='0']")).to_have_attribute("aria-pressed", "true")


def test_the_workbench_shows_messages_live_the_services_with_them(page: Page, service: FakeService) -> None:
    name = mission(service)
    service.say(name, "yard_1", "store_1", "ended(mission-1-store_1, a4)", 13.0)
    expect(page.get_by_test_id("mission")).to_be_visible()
    page.locator("#workbench-toggle").click()
    page.get_by_test_id("bench-messages").click()
    bench = page.get_by_test_id("bench-speech")
    expect(bench.locator("[data-saying]")).to_have_count(2)
    service.publish("script.cleared", "mission-1-store_1", robot="store_1", ended=["a4"])
    service.say(name, "yard_2", "yard_1", "ended(mission-1-yard_1, a9)", 30.0)
    expect(bench.locator("[data-saying]")).to_have_count(5)
    expect(bench.locator(".lifeline.of-service")).to_have_count(1)


def test_what_is_said_live_is_drawn_when_the_list_is_full_and_drops_its_oldest(
    page: Page, service: FakeService
) -> None:
    page.locator("#workbench-toggle").click()
    page.get_by_test_id("bench-messages").click()
    bench = page.get_by_test_id("bench-speech")
    service.publish("script.cleared", "script-1", robot="yard_1", ended=[f"a{n}" for n in range(1000)])
    expect(bench).to_contain_text("the newest 200 of 1000 messages")
    bench.get_by_test_id("speech-table").click()
    for action in ("b1", "b2"):
        service.publish("script.cleared", "script-2", robot="yard_1", ended=[action])
        expect(bench).to_contain_text(f"ended(script-2, {action})")
    expect(bench).to_contain_text("the newest 200 of 1000 messages")


def test_a_person_who_speaks_through_the_service_has_a_lifeline(page: Page, service: FakeService) -> None:
    asked = {"sender": "service", "receiver": "yard_1", "performative": "request", "content": "face(door_1)"}
    agreed = {"sender": "yard_1", "receiver": "service", "performative": "agree", "content": "face(door_1)"}
    said = [asked | {"sent_at_s": 3.0, "at_s": 3.0}, agreed | {"sent_at_s": 3.4, "at_s": 3.5}]
    talk = {"id": "c-1", "protocol": "fipa-request", "speaker": "ada", "said": said}
    service.conversations = [talk]
    page.locator("[data-testid=robot][data-robot=yard_1]").click()
    page.locator("#workbench-toggle").click()
    page.get_by_test_id("bench-messages").click()
    bench = page.get_by_test_id("bench-speech")
    expect(bench.locator("[data-saying]")).to_have_count(2)
    expect(bench.locator("[data-saying]").last).to_have_accessible_name(
        "3.4 s: yard_1 to ada, agree face(door_1)"
    )
    expect(bench.locator(".lifeline.of-person")).to_have_text("adaada")
    done = agreed | {"performative": "inform", "content": "done", "sent_at_s": 9.0, "at_s": 9.1}
    told = done | {"world": "sample_store", "conversation": "c-1", "protocol": "fipa-request", "speaker": ""}
    service.publish("speech.said", "yard_1", **told)
    expect(bench.locator("[data-saying]").last).to_have_accessible_name("9.0 s: yard_1 to ada, inform done")
    expect(bench.locator(".lifeline.of-service")).to_have_count(0)


def test_nothing_of_the_diagram_is_fetched_before_it_is_opened(page: Page, service: FakeService) -> None:
    mission(service)
    expect(page.get_by_test_id("mission-speech")).to_be_visible()
    fetched: list[Any] = page.evaluate("performance.getEntriesByType('resource').map((one) => one.name)")
    assert not [name for name in fetched if "/speech" in name]


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("view", ["diagram", "table"])
def test_messages_are_usable_by_everyone(page: Page, service: FakeService, theme: str, view: str) -> None:
    page.emulate_media(color_scheme=theme)  # type: ignore[arg-type]
    panel = opened(page, service)
    page.get_by_test_id(f"speech-{view}").click()
    if view == "diagram":
        panel.locator("[data-saying='2']").click()
    found = axe.Axe().run(page, context="[data-testid=mission-speech]")
    assert found.violations_count == 0, found.generate_report()
