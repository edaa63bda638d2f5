"""Reviewing a plan on the console: the picture, an action's reasons, the table, the confirmation."""

import re

import pytest

from tests.web.fake_service import FakeService
from tests.web.page_controls import boxes

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser


@pytest.fixture
def plan(page: Page, service: FakeService) -> Page:
    service.propose("move sample_1 to bay_1")
    expect(page.get_by_test_id("plan")).to_be_visible()
    return page


def test_every_action_lies_in_its_robots_lane_at_its_time(plan: Page) -> None:
    a1, a2, a5, a6 = boxes(plan, *(f"[data-action={name}] .bar" for name in ("a1", "a2", "a5", "a6")))
    assert a1["y"] == a2["y"] != a5["y"] == a6["y"]
    assert a1["x"] == pytest.approx(a5["x"], abs=1)
    assert a2["x"] == pytest.approx(a1["x"] + a1["width"], abs=1)
    assert a5["width"] / a1["width"] == pytest.approx(11.4 / 4.2, rel=0.02)


def test_links_between_robots_are_drawn_with_the_fact_they_carry(plan: Page) -> None:
    links = plan.locator(".links:not(.chosen) .link")
    expect(links).to_have_count(1)
    expect(links.first).to_contain_text("in(sample_1, interchange_1)")


def test_an_action_that_is_pointed_at_says_what_it_needs_and_why_it_is_there(plan: Page) -> None:
    plan.locator("[data-action=a4]").hover()
    detail = plan.get_by_test_id("action-detail")
    expect(detail).to_contain_text("a4 RELEASE2")
    expect(detail).to_contain_text("can(yard_1, RELEASE2)")
    expect(detail).to_contain_text("yard_2 instead of yard_1: +7.2 s")
    expect(plan.locator(".links.chosen .link")).to_have_count(2)
    plan.get_by_test_id("plan-state").hover()
    expect(detail).to_contain_text("Point at an action")


def test_arrow_keys_go_from_action_to_action_and_from_lane_to_lane(plan: Page) -> None:
    plan.get_by_test_id("plan-as-table").focus()
    plan.keyboard.press("Tab")
    detail = plan.get_by_test_id("action-detail")
    for key, action in (("", "a1"), ("ArrowRight", "a2"), ("ArrowUp", "a5"), ("ArrowRight", "a6")):
        if key:
            plan.keyboard.press(key)
        expect(detail).to_have_text(re.compile(f"^{action} "))
    plan.set_viewport_size({"width": 1100, "height": 800})  # the picture is drawn anew
    expect(plan.locator("[data-action=a6]")).to_be_focused()
    plan.keyboard.press("Enter")
    expect(plan.locator("[data-action=a6]")).to_have_attribute("aria-pressed", "true")


def test_the_table_is_kept_by_those_who_prefer_it(plan: Page) -> None:
    plan.get_by_test_id("plan-as-table").click()
    expect(plan.get_by_test_id("action-table").locator("tbody tr")).to_have_count(8)
    expect(plan.get_by_test_id("picture")).to_be_hidden()
    plan.reload()
    expect(plan.get_by_test_id("action-table")).to_be_visible()


def test_an_approval_names_the_robots_that_will_move_and_can_be_thought_better_of(
    plan: Page, service: FakeService
) -> None:
    plan.keyboard.press("a")
    dialog = plan.get_by_test_id("plan-dialog")
    expect(dialog).to_contain_text("These 2 robots will move")
    expect(dialog).to_contain_text("yard_1 NAVIGATE, DOCK, TRANSPORT, RELEASE2")
    plan.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    assert service.decisions == []
    plan.keyboard.press("a")
    expect(dialog).to_be_visible()
    plan.keyboard.press("Enter")
    expect(plan.get_by_test_id("mission-state")).to_have_text("running")
    assert [decision[:2] for decision in service.decisions] == [("plan-1", "approve")]


def test_an_approval_may_let_robots_out_of_contact_do_legs_of_each_other(
    plan: Page, service: FakeService
) -> None:
    plan.get_by_test_id("plan-approve").click()
    plan.get_by_test_id("plan-delegate").check()
    plan.get_by_test_id("plan-confirm").click()
    expect(plan.get_by_test_id("mission-state")).to_have_text("running")
    assert [decision[:2] for decision in service.decisions] == [("plan-1", "approve"), ("plan-1", "delegate")]


def test_keys_that_decide_are_letters_where_something_is_written(plan: Page, service: FakeService) -> None:
    plan.get_by_test_id("plan-comment").press_sequentially("a rare one")
    expect(plan.get_by_test_id("plan-dialog")).to_have_count(0)
    expect(plan.get_by_test_id("plan-comment")).to_have_value("a rare one")


def test_who_decided_what_and_why_stays_visible(plan: Page, service: FakeService) -> None:
    decided = {"decided_by": "administrator", "decided_at": "2026-11-20T12:00:00Z", "comment": "too long"}
    service.plans["plan-1"] |= {"state": "rejected", **decided}
    service.publish("plan.rejected", "plan-1")
    expect(plan.get_by_test_id("plan-decided")).to_contain_text("rejected by administrator")
    expect(plan.get_by_test_id("plan-decided")).to_contain_text("“too long”")


def test_what_happens_is_drawn_beneath_what_was_planned(plan: Page, service: FakeService) -> None:
    service.approve("plan-1")
    mission = service.missions["mission-1"]
    first, second = mission["progress"][0]["packets"][:2]
    start_s = mission["started_at_s"]
    first |= {"state": "finished", "started_at_s": start_s, "finished_at_s": start_s + 6.2}
    second |= {"state": "running", "started_at_s": start_s + 6.2}
    service.time_s = start_s + 8.0
    service.publish("mission.progress", "mission-1")
    expect(plan.locator(".actual.finished")).to_have_count(1)
    expect(plan.locator(".actual.overrun").first).to_be_attached()
    planned, longer = boxes(plan, "[data-action=a1] .bar", ".actual.overrun")
    assert longer["width"] / planned["width"] == pytest.approx(2.0 / 4.2, rel=0.05)
    expect(plan.locator(".upright.now")).to_have_count(1)


def test_a_deadline_after_the_plans_end_is_drawn_where_it_falls(plan: Page, service: FakeService) -> None:
    service.approve("plan-1")
    mission = service.missions["mission-1"]
    mission["deadline_s"] = mission["started_at_s"] + 60.0
    service.publish("mission.running", "mission-1")
    expect(plan.locator(".upright.deadline line")).to_be_attached()
    due, first = boxes(plan, ".upright.deadline line", "[data-action=a2] .bar")
    begins = first["x"] - 4.2 / 5.0 * first["width"]
    assert (due["x"] - begins) / first["width"] == pytest.approx(60.0 / 5.0, rel=0.02)
    expect(plan.get_by_test_id("mission")).to_contain_text("due at 1 min 00 s")


def test_a_mission_that_takes_longer_tells_both_estimates(plan: Page, service: FakeService) -> None:
    service.approve("plan-1")
    service.missions["mission-1"]["estimate_s"] = 55.0
    service.time_s += 50.0
    service.publish("mission.overdue", "mission-1")
    expect(plan.get_by_test_id("mission")).to_contain_text("50.0 s of 55.0 s estimated (at first 40.9 s)")


def test_who_approved_stays_visible_when_the_mission_has_ended(plan: Page, service: FakeService) -> None:
    service.plans["plan-1"] |= {"decided_by": "ann", "decided_at": "2026-11-20T12:00:00Z", "comment": "go on"}
    service.approve("plan-1")
    service.complete("mission-1")
    expect(plan.get_by_test_id("mission-state")).to_have_text("completed")
    expect(plan.get_by_test_id("plan-decided")).to_contain_text("approved by ann")
    expect(plan.get_by_test_id("plan-decided")).to_contain_text("“go on”")


def test_who_has_bid_what_for_a_plan_is_shown_once_it_is_opened(page: Page, service: FakeService) -> None:
    offer = {"cost_s": 30.2, "release_s": 0.0, "way_s": 1.7, "work_s": 28.5, "battery": 0.98}
    bids = [
        {"robot": "yard_1", "state": "offered", "offer": offer, "reason": ""},
        {"robot": "yard_2", "state": "declined", "offer": None, "reason": "it holds a tool"},
    ]
    leg = {
        "id": "leg_1",
        "goal": {"predicate": "in", "args": ["sample_1", "bay_1"]},
        "parts": [{"tags": ["DOCK", "TRANSPORT"], "bids": bids}],
        "team": ["yard_1"],
        "why": "yard_1 asks 30 s, nobody else bids",
        "is_planned": True,
    }
    service.propose("move sample_1 to bay_1", tender={"reason": "", "legs": [leg]})
    shown = page.get_by_test_id("robots")
    shown.locator("summary").click()
    expect(shown).to_contain_text("leg_1, in(sample_1, bay_1): awarded to yard_1")
    expect(shown).to_contain_text("yard_1 asks 30 s, nobody else bids")
    expect(shown).to_contain_text("battery 98 % after it")
    expect(shown).to_contain_text("yard_2 declined: it holds a tool")


def test_why_a_plan_has_its_robots_is_shown_once_it_is_opened(plan: Page) -> None:
    shown = plan.get_by_test_id("robots")
    shown.locator("summary").click()
    expect(shown).to_contain_text("nearest of two that reach door_1")
    expect(shown).not_to_contain_text("awarded")


def test_a_change_is_planned_beside_the_plan_and_shown(plan: Page, service: FakeService) -> None:
    plan.get_by_test_id("edit").locator("summary").click()
    plan.get_by_test_id("edit-action").select_option("a2")
    robots = plan.get_by_test_id("edit-value").locator("option")
    expect(robots).to_have_text(["store_1", "store_2", "yard_1", "yard_2"])
    plan.get_by_test_id("edit-value").select_option("yard_2")
    plan.get_by_test_id("edit-plan").click()
    expect(plan.get_by_test_id("seek-alternatives")).to_have_text("Planning the change …")
    assert service.asked == [{"action": "a2", "robot": "yard_2"}]
    service.edited("goal-1")
    plan.get_by_test_id("alternatives").get_by_text("yard_2 for in(sample_1, bay_1)").click()
    expect(plan.get_by_test_id("repairs")).to_contain_text("Edited: 7 of 8 actions kept, ends 7 s later")


def test_what_comes_after_is_chosen_among_the_other_actions(plan: Page, service: FakeService) -> None:
    plan.get_by_test_id("edit").locator("summary").click()
    plan.get_by_test_id("edit-action").select_option("a2")
    plan.get_by_test_id("edit-change").select_option(label="comes after")
    choices = plan.get_by_test_id("edit-value").locator("option")
    expect(choices.first).to_contain_text("a1 NAVIGATE: ")
    expect(plan.get_by_test_id("edit-value").locator("option[value=a2]")).to_have_count(0)
    plan.get_by_test_id("edit-action").select_option("a1")
    expect(plan.get_by_test_id("edit-value").locator("option[value=a1]")).to_have_count(0)
    plan.get_by_test_id("edit-value").select_option("a3")
    plan.get_by_test_id("edit-plan").click()
    expect(plan.get_by_test_id("seek-alternatives")).to_have_text("Planning the change …")
    assert service.asked == [{"action": "a1", "after": "a3"}]


def test_what_samples_go_through_is_chosen_among_the_interchanges(plan: Page, service: FakeService) -> None:
    plan.get_by_test_id("edit").locator("summary").click()
    plan.get_by_test_id("edit-change").select_option(label="goes through")
    expect(plan.get_by_test_id("edit-value").locator("option")).to_have_text(
        ["interchange_1", "interchange_2"]
    )
    plan.get_by_test_id("edit-value").select_option("interchange_2")
    plan.get_by_test_id("edit-plan").click()
    expect(plan.get_by_test_id("seek-alternatives")).to_have_text("Planning the change …")
    assert service.asked == [{"action": "a1", "via": "interchange_2"}]


def test_what_a_mission_has_not_done_is_planned_again_with_a_change_or_without(
    plan: Page, service: FakeService
) -> None:
    service.approve("plan-1")
    expect(plan.get_by_test_id("plan-state")).to_have_text("approved")
    plan.get_by_test_id("edit").locator("summary").click()
    expect(plan.get_by_test_id("edit")).to_contain_text("What is not done yet is planned again")
    plan.get_by_test_id("edit-action").select_option("a2")
    plan.get_by_test_id("edit-value").select_option("yard_2")
    plan.get_by_test_id("edit-plan").click()
    expect(plan.get_by_test_id("mission-state")).to_have_text("recovering")
    assert service.asked == [{"action": "a2", "robot": "yard_2"}]
    plan.get_by_test_id("replan").click()
    expect(plan.get_by_test_id("replan")).to_be_enabled()
    assert service.asked == []
    service.refusal = "mission mission-1 is being planned again already"
    plan.get_by_test_id("replan").click()
    expect(plan.get_by_test_id("edit")).to_contain_text("is being planned again already")


def test_goals_that_wait_are_carried_out_by_a_mission_that_is_planned_again(
    plan: Page, service: FakeService
) -> None:
    for text, changes in (
        ("move sample_2 to bay_2", {"state": "waiting"}),
        ("move sample_3 to bay_3", {"state": "waiting", "joint_goal": "goal-9"}),
        ("move sample_4 to bay_4", {}),
    ):
        service.propose(text, **changes)
    service.approve("plan-1")
    expect(plan.get_by_test_id("plan-state")).to_have_text("approved")
    plan.get_by_test_id("edit").locator("summary").click()
    expect(plan.get_by_test_id("edit").get_by_role("group")).to_contain_text("also carry out")
    plan.get_by_label("move sample_2 to bay_2").check()
    expect(plan.get_by_test_id("join-goal")).to_have_count(1)
    plan.get_by_test_id("edit-action").select_option("a2")
    plan.get_by_test_id("preview").click()
    outcome = plan.get_by_test_id("preview-outcome")
    expect(outcome).to_contain_text("Without a change: ends in 20.0 s (by the present plan in 31.0 s)")
    expect(outcome).to_contain_text("in(sample_2, bay_1) after 20.0 s; 3 of 5 actions kept")
    expect(outcome).to_contain_text("the plan has no such action")
    expect(plan.get_by_test_id("mission-state")).to_have_text("running")
    plan.get_by_test_id("replan").click()
    expect(plan.get_by_test_id("mission-state")).to_have_text("recovering")
    assert service.asked == [{"joins": "goal-2"}]
    service.missions["mission-1"] |= {"state": "running", "joined_goals": ["goal-2"]}
    service.publish("mission.revised", "mission-1")
    expect(plan.get_by_test_id("joined-goals")).to_have_text("also carries out goal-2")


def test_a_mission_that_would_end_sooner_planned_again_says_so(plan: Page, service: FakeService) -> None:
    service.approve("plan-1")
    expect(plan.get_by_test_id("mission-state")).to_have_text("running")
    expect(plan.get_by_test_id("better-plan")).to_have_count(0)
    better = {"made_at_s": 5.0, "ends_in_s": 40.0, "saves_s": 42.0, "robots": ["yard_1", "yard_2"]}
    service.missions["mission-1"] |= {"better_plan": better}
    service.publish("mission.better_plan_found", "mission-1")
    expect(plan.get_by_test_id("better-plan")).to_contain_text("about 42.0 s sooner, with yard_1, yard_2")
    plan.get_by_test_id("take-better-plan").click()
    expect(plan.get_by_test_id("mission-state")).to_have_text("recovering")


def test_the_plan_of_a_mission_that_has_ended_is_not_changed(plan: Page, service: FakeService) -> None:
    service.approve("plan-1")
    expect(plan.get_by_test_id("mission-state")).to_have_text("running")
    expect(plan.get_by_test_id("edit")).to_be_visible()
    service.complete("mission-1")
    expect(plan.get_by_test_id("edit")).to_have_count(0)


def test_a_change_without_a_plan_says_why(plan: Page, service: FakeService) -> None:
    plan.get_by_test_id("edit").locator("summary").click()
    plan.get_by_test_id("edit-change").select_option("not_before_s")
    plan.get_by_test_id("edit-value").fill("90")
    plan.get_by_test_id("edit-value").press("Enter")
    expect(plan.get_by_test_id("seek-alternatives")).to_be_disabled()
    assert service.asked == [{"action": "a1", "not_before_s": 90}]
    service.edited("goal-1", reason="in(sample_1, bay_1) not before 90 s from then: no plan")
    expect(plan.get_by_test_id("search-reason")).to_have_text(
        "in(sample_1, bay_1) not before 90 s from then: no plan"
    )
