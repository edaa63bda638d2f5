"""The operator's console in a real browser, before a stand-in for the service."""

import re

import pytest

from tests.ports import free_port
from tests.web.fake_api import TOKEN, add_console, create_app, served
from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Browser, Page, Route, expect  # noqa: E402

pytestmark = pytest.mark.browser
HOSTILE = "<img src=x onerror=\"document.title='owned'\"><script>document.title='owned'</script>"


def approve(page: Page) -> None:
    page.get_by_test_id("plan-approve").click()
    page.get_by_test_id("plan-confirm").click()


def test_a_goal_is_planned_approved_and_seen_complete(page: Page, service: FakeService) -> None:
    page.get_by_test_id("goal-text").fill("move sample_1 to bay_1")
    page.get_by_test_id("goal-submit").click()
    expect(page.get_by_test_id("plan")).to_contain_text("8 actions, 40.9 s")
    page.get_by_test_id("plan-as-table").click()
    expect(page.get_by_test_id("plan")).to_contain_text("yard_1 drives up to sample_1 at door_1")
    page.get_by_test_id("plan-as-picture").click()
    expect(page.get_by_test_id("causal-links")).to_contain_text("Causal links (9)")
    page.get_by_test_id("plan-comment").fill("go on")
    approve(page)
    expect(page.get_by_test_id("mission-state")).to_have_text("running")
    assert service.decisions == [("plan-1", "approve", "go on")]
    service.complete("mission-1")
    expect(page.get_by_test_id("mission-state")).to_have_text("completed")
    expect(page.get_by_test_id("mission")).to_contain_text("39.0 s of 40.9 s estimated")
    expect(page.get_by_test_id("mission").locator("[data-state=finished]")).to_have_count(8)


def test_what_packets_bring_is_shown_with_the_mission_as_it_comes(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    expect(page.get_by_test_id("mission-state")).to_have_text("running")
    expect(page.get_by_test_id("results")).to_have_count(0)
    service.bring("mission-1", "image", "camera")
    image = page.get_by_alt_text("bay_1 as the camera of yard_1 sees it")
    expect(image).to_have_js_property("naturalWidth", 1)
    expect(image).to_have_attribute("src", "/v1/missions/mission-1/results/result-1")
    expect(page.locator("figcaption")).to_have_text(re.compile(r"^bay_1, by yard_1, \d+:03( [AP]M)?$"))
    service.bring("mission-1", "reading", HOSTILE, value=412.345, unit="lx")
    expect(page.locator(".results .reading")).to_contain_text(f"{HOSTILE} 412.3 lx")
    page.get_by_title("Show it large").click()
    expect(page.get_by_test_id("result-dialog").get_by_role("img")).to_have_js_property("naturalWidth", 1)
    page.get_by_role("button", name="Close").click()
    expect(page.get_by_test_id("result-dialog")).to_have_count(0)


def test_alternatives_are_compared_and_the_one_looked_at_is_approved(
    page: Page, service: FakeService
) -> None:
    service.propose("move sample_1 to bay_1")
    page.get_by_test_id("seek-alternatives").click()
    table = page.get_by_test_id("alternatives")
    cards = table.get_by_role("button")
    expect(cards).to_have_count(2)
    expect(cards.nth(0)).to_have_attribute("aria-pressed", "true")
    expect(cards.nth(0).locator(".figure.best")).to_have_text("takes40.9 s best")
    expect(cards.nth(1).locator(".figure.best")).to_have_text("drives12.9 m best")
    expect(cards.nth(1)).to_contain_text("store_1, yard_2")
    cards.nth(0).focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    expect(page.get_by_test_id("plan")).to_contain_text("without yard_1: 7.2 s longer")
    expect(cards.nth(1)).to_have_attribute("aria-pressed", "true")
    expect(cards.nth(1)).to_be_focused()
    approve(page)
    expect(page.get_by_test_id("mission-state")).to_have_text("running")
    assert [decision[:2] for decision in service.decisions] == [("plan-1b", "approve")]


def test_a_plan_says_why_it_is_as_it_is(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    why = page.get_by_test_id("why")
    why.locator("summary").click()
    expect(why).to_contain_text("yard_2 instead of yard_1: +7.2 s")
    expect(why).to_contain_text("avoiding bay_3")
    expect(why).to_contain_text("it costs no time: no plan without it is shorter")
    expect(why).to_contain_text("there is no plan without store_1")


def test_a_rejection_needs_a_comment_and_carries_it(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    page.get_by_test_id("plan-reject").click()
    expect(page.get_by_test_id("plan")).to_contain_text("Say in the comment why")
    assert service.decisions == []
    page.get_by_test_id("plan-comment").fill("use the other door")
    page.get_by_test_id("plan-reject").click()
    expect(page.get_by_test_id("plan-state")).to_have_text("rejected")
    expect(page.get_by_test_id("plan-approve")).to_have_count(0)
    assert service.decisions == [("plan-1", "reject", "use the other door")]


def test_an_error_of_the_service_is_shown(page: Page, service: FakeService) -> None:
    page.get_by_test_id("goal-text").fill("move sample_9 to bay_1")
    page.get_by_test_id("goal-submit").click()
    expect(page.get_by_test_id("goal-problem")).to_contain_text("There is no sample_9 in sample_store")
    expect(page.get_by_test_id("goal-text")).to_have_value("move sample_9 to bay_1")
    assert service.goals == {}


def test_a_sentence_is_said_what_it_lacks_and_goes_on_by_the_keyboard_alone(
    page: Page, service: FakeService
) -> None:
    text, hint = page.get_by_test_id("goal-text"), page.get_by_test_id("goal-hint")
    text.press_sequentially("move")
    expect(hint).to_have_text("move which sample?")
    for _ in range(2):
        text.press("ArrowDown")
    text.press("Enter")
    expect(text).to_have_value("move sample_2")
    expect(hint).to_have_text("move sample_2 where to?")
    text.press("ArrowDown")
    text.press("Enter")
    expect(text).to_have_value("move sample_2 to bay_1")
    expect(hint).to_have_text("understood: in(sample_2, bay_1)")
    assert service.goals == {}
    text.press("Enter")
    expect(page.get_by_test_id("goal-item")).to_contain_text("move sample_2 to bay_1")


def test_text_from_elsewhere_is_never_read_as_markup(page: Page, service: FakeService) -> None:
    service.propose(HOSTILE, reason=HOSTILE)
    plan = service.plans["plan-1"]
    plan |= {"comment": HOSTILE, "engine": HOSTILE, "recruitment": {HOSTILE: HOSTILE}}
    plan["actions"] = [plan["actions"][0] | {"tag": HOSTILE, "description": HOSTILE, "agents": [HOSTILE]}]
    service.approve("plan-1")
    service.missions["mission-1"] |= {"reason": HOSTILE, "failure": HOSTILE}
    service.publish("mission.failed", "mission-1")
    expect(page.get_by_test_id("goal-item")).to_contain_text(HOSTILE)
    expect(page.get_by_test_id("plan")).to_contain_text(HOSTILE)
    expect(page.get_by_test_id("mission")).to_contain_text(HOSTILE)
    assert page.locator("img").count() == 0
    assert page.title() == "Macta"


def test_a_running_mission_is_paused_resumed_and_cancelled(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    for control, state in (("pause", "paused"), ("resume", "running"), ("cancel", "cancelled")):
        page.get_by_test_id(f"mission-{control}").click()
        expect(page.get_by_test_id("mission-state")).to_have_text(state)
    expect(page.get_by_test_id("mission-cancel")).to_have_count(0)


def test_a_mission_that_waits_for_its_robots_to_stop_says_so_and_takes_no_other_order(
    page: Page, service: FakeService
) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.missions["mission-1"] |= {"cancel_requested": True, "state": "unknown"}
    service.publish("mission.cancel_requested", "mission-1")
    expect(page.get_by_test_id("mission-ending")).to_have_text("being cancelled: waits for its robots")
    expect(page.get_by_test_id("mission-pause")).to_have_count(0)
    expect(page.get_by_test_id("mission-cancel")).to_have_count(0)


@pytest.mark.parametrize(
    ("outcome", "word", "tone"),
    [
        ("completed", "completed", "good"),
        ("failed", "failed", "bad"),
        ("cancelled", "cancelled", "bad"),
        ("partially_completed", "partially completed", "bad"),
    ],
)
def test_a_finished_goal_shows_what_came_of_it(
    page: Page, service: FakeService, outcome: str, word: str, tone: str
) -> None:
    service.propose("move sample_1 to bay_1", state="finished", outcome=outcome)
    for badge in (page.get_by_test_id("goal-item").locator(".badge"), page.get_by_test_id("goal-state")):
        expect(badge).to_have_text(word)
        expect(badge).to_have_class(f"badge {tone}")


def test_a_comment_being_written_survives_other_news(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    page.get_by_test_id("plan-comment").fill("not yet done writ")
    service.propose("move sample_2 to bay_3")
    expect(page.get_by_test_id("goal-item")).to_have_count(2)
    expect(page.get_by_test_id("plan-comment")).to_have_value("not yet done writ")


def test_what_a_sentence_was_resolved_to_is_shown_before_it_is_planned(
    page: Page, service: FakeService
) -> None:
    text, terms = page.get_by_test_id("goal-text"), page.get_by_test_id("goal-terms")
    expect(terms).to_be_hidden()
    text.fill("park every robot with yard_1")
    expect(terms.get_by_role("listitem")).to_have_text(["“every robot”: yard_1, yard_2", "only with: yard_1"])
    text.fill("park every robot")
    expect(terms).to_be_hidden()


def test_a_goals_terms_are_shown_with_it(page: Page, service: FakeService) -> None:
    readings = [{"said": "then", "means": ["in(sample_1, bay_1)", "near(yard_1, door_1)"]}]
    service.propose("move sample_1 to bay_1 then send yard_1 to door_1", readings=readings)
    kept = page.get_by_test_id("goal-terms-kept")
    expect(kept.get_by_role("listitem")).to_have_text(
        ["“then”: in(sample_1, bay_1), then near(yard_1, door_1)"]
    )


def test_the_page_holds_no_token_in_its_address(page: Page) -> None:
    expect(page).to_have_url(re.compile(r"^http://127\.0\.0\.1:\d+/$"))


def test_the_badge_says_when_the_page_is_not_live_and_live_again(
    browser: Browser, service: FakeService
) -> None:
    app, port = create_app(service), free_port()
    add_console(app)
    page = browser.new_page()
    with served(app, service, port) as address:
        page.goto(f"{address}/?token={TOKEN}")
        expect(page.get_by_test_id("live-badge")).to_have_text("live")
    expect(page.get_by_test_id("live-badge")).to_have_text("not live")
    with served(app, service, port):
        service.propose("move sample_1 to bay_1")
        expect(page.get_by_test_id("live-badge")).to_have_text("live")
        expect(page.get_by_test_id("goal-item")).to_have_count(1)
    page.close()


def test_the_page_is_live_once_nothing_that_it_loads_moves_its_buttons(
    browser: Browser, service: FakeService
) -> None:
    """The robots' list comes above the world's buttons: a click while they move is lost."""
    app, held, is_held = create_app(service), list[Route](), True
    add_console(app)

    def hold(route: Route) -> None:
        if is_held:
            held.append(route)
        else:
            route.continue_()

    with served(app, service) as address:
        page = browser.new_page()
        page.route("**/v1/robots", hold)
        with page.expect_response(re.compile("/v1/events")), page.expect_response("**/v1/worlds"):
            page.goto(f"{address}/?token={TOKEN}")
        live, as_map = page.get_by_test_id("live-badge"), page.locator("#as-map")
        before = as_map.bounding_box()
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        assert live.inner_text() == "not live"
        is_held = False
        for route in held:
            route.continue_()
        expect(live).to_have_text("live")
        loaded = as_map.bounding_box()
        assert loaded != before
        page.wait_for_event("response", lambda response: response.url.endswith("/v1/robots"))
        assert as_map.bounding_box() == loaded
        page.close()


def test_what_was_not_answered_is_asked_for_again_though_no_event_comes(
    page: Page, service: FakeService
) -> None:
    live = page.get_by_test_id("live-badge")
    page.route(re.compile("/v1/goals[/?]"), lambda route: route.abort())
    service.propose("move sample_1 to bay_1")
    expect(live).to_have_text("not live")
    for _ in range(2):  # the worlds' clocks are answered all the while
        page.wait_for_event("response", lambda response: response.url.endswith("/v1/worlds"))
    assert live.inner_text() == "not live"
    page.unroute_all()
    expect(page.get_by_test_id("goal-item")).to_contain_text("move sample_1 to bay_1")
    expect(live).to_have_text("live")
