"""The console where a mission has failed: what was tried, what is not known, and what an operator may say of it."""

import pytest

from tests.web.fake_service import FakeService
from tests.web.page_controls import boxes, hold_first

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser


def under_way(page: Page, service: FakeService) -> str:
    """The id of a mission that the page shows."""
    service.propose("move sample_1 to bay_1")
    mission_id: str = service.approve("plan-1")["mission_id"]
    expect(page.get_by_test_id("mission-state")).to_have_text("running")
    return mission_id


def test_a_repair_is_shown_with_what_befell_whom_and_its_difference(page: Page, service: FakeService) -> None:
    service.ask_about_repair(under_way(page, service))
    expect(page.get_by_test_id("mission-state")).to_have_text("recovering")
    recovery = page.get_by_test_id("recovery")
    expect(recovery).to_contain_text("waits for your decision")
    expect(recovery).to_contain_text("yard_1: the gripper does not close")
    expect(recovery).to_contain_text("without DOCK by yard_1")
    repairs = page.get_by_test_id("repairs")
    expect(repairs).to_contain_text("4 of 8 actions kept, ends 7 s later")
    expect(repairs.get_by_text("new: yard_2 deposits")).to_be_visible()
    expect(page.get_by_test_id("plan-approve")).to_be_visible()


def test_a_repair_is_drawn_with_what_is_new_what_is_dropped_and_what_has_moved(
    page: Page, service: FakeService
) -> None:
    service.ask_about_repair(under_way(page, service))
    expect(page.locator(".action.new")).to_have_count(4)
    expect(page.locator(".action.moved")).to_have_count(3)
    dropped, moved = page.locator(".ghost.dropped"), page.locator(".ghost.moved")
    expect(dropped).to_have_count(3)
    expect(moved).to_have_count(3)
    now, was = boxes(page, "[data-action=a6] .bar", ".ghost.moved rect")
    assert now["width"] == pytest.approx(was["width"], abs=2)
    assert (now["x"] - was["x"]) / now["width"] == pytest.approx(6.8 / 5.0, rel=0.05)
    page.locator("[data-action=a3]").hover()
    expect(page.get_by_test_id("action-detail")).to_contain_text("instead of yard_1")
    page.get_by_test_id("plan-as-table").click()
    table = page.get_by_test_id("action-table")
    expect(table.locator("tr").filter(has_text="a6")).to_contain_text("7 s later than before")


def test_a_plan_that_the_world_has_overtaken_says_what_has_changed_where_it_is_decided_on(
    page: Page, service: FakeService
) -> None:
    service.propose("move sample_1 to bay_1")
    expect(page.get_by_test_id("plan-approve")).to_be_visible()
    page.get_by_test_id("plan-comment").press_sequentially("half a ")
    change = "in(sample_1, door_1) is no longer true: now in(sample_1, bay_3), operator ann at 34 s"
    service.plans["plan-1"]["overtaken"] = [change]
    service.publish("world.facts_changed", "sample_store")
    expect(page.get_by_test_id("overtaken").locator("li")).to_have_text([change])
    page.keyboard.type("word")
    expect(page.get_by_test_id("plan-comment")).to_have_value("half a word")
    service.approve("plan-1")
    service.plans["plan-1"]["reason"] = change
    service.ask_about_repair("mission-1")
    expect(page.get_by_test_id("repairs")).to_contain_text(f"The plan before was overtaken: {change}")


def test_what_becomes_of_failures_can_be_set_while_the_mission_runs(page: Page, service: FakeService) -> None:
    mission_id = under_way(page, service)
    policy = page.get_by_test_id("mission-policy")
    expect(policy).to_have_value("ask")
    with page.expect_response("**/recovery"):
        policy.select_option("never")
    expect(policy).to_have_value("never")
    assert service.missions[mission_id]["recovery"]["policy"] == "never"
    service.complete(mission_id)
    expect(policy).to_have_count(0)


def test_a_focused_command_keeps_the_focus_when_the_mission_reports(page: Page, service: FakeService) -> None:
    mission_id = under_way(page, service)
    page.get_by_test_id("mission-pause").focus()
    service.missions[mission_id]["reason"] = "yard_1 is late"
    service.publish("mission.running", mission_id)
    expect(page.get_by_test_id("mission")).to_contain_text("yard_1 is late")
    expect(page.get_by_test_id("mission-pause")).to_be_focused()


def test_what_is_not_known_is_listed_with_what_was_believed_last(page: Page, service: FakeService) -> None:
    expect(page.get_by_test_id("unknown")).to_have_count(0)
    first = {"predicate": "in", "args": ["sample_1", "door_1"], "source": "world file", "at_s": 0.0}
    last = {"predicate": "in", "args": ["sample_1", "bay_7"], "source": "operator ann", "at_s": 8.0}
    reason = "it is not where it was believed to be (report of yard_1)"
    service.unknown = [
        {
            "name": "sample_1",
            "kind": "sample",
            "reason": reason,
            "since_s": 34.0,
            "last_believed": last,
            "earlier_believed": [first],
        }
    ]
    service.publish("world.facts_changed", "sample_store")
    unknown = page.get_by_test_id("unknown")
    expect(unknown).to_contain_text("Not known (1)")
    expect(unknown).to_contain_text("last believed in(sample_1, bay_7), operator ann at 8.0 s")
    expect(unknown).to_contain_text("before that in(sample_1, door_1), world file at 0.0 s")


def test_silence_is_stated_in_words_and_hatched_from_the_instant_it_began(
    page: Page, service: FakeService
) -> None:
    mission_id = under_way(page, service)
    service.missions[mission_id] |= {"state": "unknown", "reason": "yard_1 has not answered"}
    service.time_s += 50.0
    unheard = {"connection": "offline", "mission_id": mission_id}
    service.hearing["yard_1"] = unheard | {
        "silent": True,
        "last_heard_s": 43.0,
        "heard_at_s": service.time_s - 40.9,
    }
    service.hearing["store_1"] = unheard | {"heard_at_s": service.time_s - 5.0, "next_contact_s": 118.0}
    service.hearing["yard_2"] = {"world_stands": True, "last_heard_s": 43.0}
    service.publish("mission.unknown", mission_id)
    expect(page.get_by_test_id("mission-state")).to_have_class("badge unknown")
    robots = page.get_by_test_id("robot")
    expect(robots.filter(has_text="yard_1")).to_contain_text("silent")
    expect(robots.filter(has_text="yard_1")).to_contain_text("last heard 43 s ago")
    expect(robots.filter(has_text="store_1")).to_contain_text("last heard 5 s ago, next contact in 2 min")
    expect(robots.filter(has_text="yard_2")).to_contain_text("its world stands at a breakpoint")
    silences = page.get_by_test_id("silence")
    expect(silences).to_have_count(2)
    expect(silences.first).to_contain_text("yard_1 silent last heard 43 s ago")
    hatch, axis, planned = boxes(page, ".unheard.unknown rect", ".upright.now line", "[data-action=a8] .bar")
    assert hatch["width"] / planned["width"] == pytest.approx(40.9 / 6.0, rel=0.05)
    assert hatch["x"] + hatch["width"] == pytest.approx(axis["x"], abs=2)
    service.hearing.clear()
    service.publish("mission.running", mission_id)
    expect(page.locator(".unheard")).to_have_count(0)
    expect(silences).to_have_count(0)


def test_of_two_answers_on_their_way_at_once_the_one_asked_for_later_counts(
    page: Page, service: FakeService
) -> None:
    mission_id = under_way(page, service)
    robot = page.get_by_test_id("robot").filter(has_text="yard_1")
    held = hold_first(page, "**/v1/robots")
    held.wait()
    service.hearing["yard_1"] = {"connection": "offline", "silent": True, "last_heard_s": 43.0}
    service.publish("mission.unknown", mission_id)
    expect(robot).to_contain_text("silent")
    held.hand_over()
    assert "silent" in robot.inner_text()


def test_a_repaired_plans_mission_is_drawn_from_the_repair_on(page: Page, service: FakeService) -> None:
    mission = service.missions[under_way(page, service)]
    mission |= {"revised_at_s": service.time_s + 30.0, "started_at_s": service.time_s}
    first = mission["progress"][0]["packets"][0]
    first |= {"started_at_s": service.time_s + 30.0, "state": "running"}
    service.time_s += 34.0
    service.publish("mission.revised", mission["id"])
    expect(page.get_by_test_id("mission")).to_contain_text("34.0 s of 40.9 s estimated")
    # The clock comes by itself, before what has become of the mission or after it.
    expect(page.locator("g:has(> .actual.running) > title")).to_have_text(
        "yard_1 NAVIGATE: running, 4.0 s of 4.2 s planned"
    )
    box, planned = boxes(page, ".actual.running", "[data-action=a1] .bar")
    assert box["x"] == pytest.approx(planned["x"], abs=1)
    assert box["width"] / planned["width"] == pytest.approx(4.0 / 4.2, rel=0.05)
