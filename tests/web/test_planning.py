"""The console while goals are planned: progress, stopping, how good a plan is, repairs, deadlines, waiting."""

import re
from typing import Any

import pytest

from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
GOAL = "move sample_1 to bay_1"


def test_an_operator_sees_how_far_the_planning_is_and_takes_the_best(
    page: Page, service: FakeService
) -> None:
    goal = service.propose(GOAL)["id"]
    service.plan_on(goal)
    progress = page.get_by_test_id("planning")
    expect(progress).to_contain_text(re.compile(r"No plan yet after \d+ s, macta"))
    # Told once, at 1.5 s: the time goes on.
    expect(progress).to_contain_text(re.compile(r"after ([4-9]|\d\d) s"))
    service.plan_on(goal, makespan_s=140.0, lower_bound_s=100.0, elapsed_s=120.0)
    expect(progress).to_contain_text("Best plan so far: 2 min 20 s after 2 min")
    service.plan_on(goal, makespan_s=110.0, lower_bound_s=100.0, elapsed_s=121.0)
    expect(progress.get_by_role("img", name="From 2 min 20 s to 1 min 50 s in 2 min")).to_be_visible()
    expect(progress).to_contain_text("at most 10 % over the quickest possible (1 min 40 s)")
    expect(page.get_by_test_id("plan")).to_have_count(0)
    page.get_by_test_id("goal-stop").click()
    expect(page.get_by_test_id("plan-approve")).to_be_visible()
    expect(page.get_by_test_id("goal-stop")).to_have_count(0)
    assert service.stopped == [(goal, "stop")]


def test_a_goal_is_withdrawn(page: Page, service: FakeService) -> None:
    goal = service.propose(GOAL)["id"]
    page.get_by_test_id("goal-cancel").click()
    expect(page.get_by_test_id("goal-state")).to_have_text("withdrawn")
    expect(page.get_by_test_id("goal-cancel")).to_have_count(0)
    assert service.stopped == [(goal, "cancel")]


def test_a_goal_carries_the_wishes_that_were_filled_in(page: Page, service: FakeService) -> None:
    page.get_by_test_id("goal-wishes").locator("summary").click()
    page.get_by_label("due within").fill("90")
    page.get_by_label("aim at").select_option("energy")
    page.get_by_test_id("goal-text").fill(GOAL)
    page.get_by_test_id("goal-submit").click()
    expect(page.get_by_test_id("plan")).to_be_visible()
    (asked,) = service.asked
    assert asked == {"world": "sample_store", "text": GOAL, "deadline_s": 90, "objective": "energy"}


@pytest.mark.parametrize(
    ("bound_s", "words"),
    [(40.9, "no plan is quicker"), (30.0, "at most 37 % over the quickest possible (30.0 s)")],
)
def test_a_plan_says_how_far_it_may_be_from_the_best(
    page: Page, service: FakeService, bound_s: float, words: str
) -> None:
    service.propose(GOAL)
    service.plans["plan-1"] |= {"lower_bound_s": bound_s, "distance_m": 14.2, "energy_j": 556.4}
    service.publish("plan.proposed", "plan-1")
    expect(page.get_by_test_id("figures")).to_have_text(f"{words} · 14.2 m to drive · 556 J")


def test_a_repaired_plan_says_what_is_different(page: Page, service: FakeService) -> None:
    service.propose(GOAL)
    words = ["7 of 8 actions kept, ends 7 s later", "new: store_1 goes to bay_6"]
    difference = {"words": words, "later_s": 7.0}
    service.plans["plan-1"]["repairs"] = {"plan_id": "plan-0", "course": "mended", "difference": difference}
    service.publish("plan.proposed", "plan-1")
    repairs = page.get_by_test_id("repairs")
    expect(repairs.locator("summary")).to_have_text("Repaired (mended): 7 of 8 actions kept, ends 7 s later")
    repairs.locator("summary").click()
    expect(repairs.locator("li")).to_have_text(["new: store_1 goes to bay_6"])


def test_a_deadline_is_counted_down_and_a_plan_that_misses_it_says_so(
    page: Page, service: FakeService
) -> None:
    service.propose(GOAL, deadline_s=30.0, deadline_at_s=service.time_s + 20.0, priority=5)
    service.plans["plan-1"]["late"] = [{"goal": {"predicate": "in", "args": ["sample_1"]}, "late_s": 20.9}]
    service.publish("plan.proposed", "plan-1")
    expect(page.get_by_test_id("goal-due")).to_have_text("due in 20.0 s, priority 5")
    expect(page.get_by_test_id("late")).to_have_text("in(sample_1) comes 20.9 s after its deadline")
    service.time_s += 25.0
    expect(page.get_by_test_id("goal-due")).to_have_text("due 5.0 s ago, priority 5")


def test_the_chance_to_be_on_time_sinks_while_a_plan_waits(page: Page, service: FakeService) -> None:
    service.propose(GOAL, deadline_s=60.0, deadline_at_s=service.time_s + 60.0)
    goal = {"predicate": "in", "args": ["sample_1", "bay_1"]}
    service.plans["plan-1"]["forecast"] = {
        "goals": [{"goal": goal, "p10_s": 40, "p50_s": 50, "p90_s": 60, "deadline_s": 60.0, "on_time": 0.9}],
        "on_time": 0.9,
        "lateness_quantiles_s": [-30.0, -20.0, -10.0, 0.0, 10.0],
        "probabilities": [0.0, 0.1, 0.5, 0.9, 1.0],
        "made_at_s": service.time_s,
    }
    service.publish("plan.proposed", "plan-1")
    chance = page.get_by_test_id("on-time")
    expect(chance).to_have_text("90 % likely on time if it starts now")
    service.time_s += 15.0
    expect(chance).to_have_text("30 % likely on time if it starts now")
    service.time_s += 100.0
    expect(chance).to_have_text("0 % likely on time if it starts now")
    page.get_by_test_id("forecast").locator("summary").click()
    expect(page.get_by_test_id("likely-times").locator("tbody tr")).to_have_count(1)
    expect(page.get_by_test_id("likely-times")).to_contain_text("50.0 s")


def test_what_a_plan_leaves_out_is_told_with_its_worth_and_why(page: Page, service: FakeService) -> None:
    service.propose(GOAL)
    goal = {"predicate": "in", "args": ["sample_3", "bay_8"]}
    why = "with it a goal would be 12 s late"
    service.plans["plan-1"] |= {
        "value": 7.0,
        "value_bound": 9.0,
        "left_out": [{"goal": goal, "value": 2.0, "reason": why}],
    }
    service.publish("plan.proposed", "plan-1")
    left_out = page.get_by_test_id("left-out")
    expect(left_out).to_contain_text("Optional goals worth 7 (at most 9 with more time); left out:")
    expect(left_out.locator("li")).to_have_text([f"in(sample_3, bay_8), worth 2: {why}"])


def test_which_preferences_a_plan_keeps_is_told_with_the_reasons(page: Page, service: FakeService) -> None:
    service.propose(GOAL)
    makespan_s = service.plans["plan-1"]["makespan_s"]
    why = "the shortest plan found that keeps it takes 31.0 s longer"
    service.plans["plan-1"]["preferences"] = {
        "outcomes": [
            {"preference": "preferably avoiding bay_3", "cost_s": 60.0, "kept": True, "reason": ""},
            {"preference": "preferably without yard_1", "cost_s": 10.0, "kept": False, "reason": why},
        ],
        "cost_s": 10.0,
        "bound_s": 12.0,
        "cut_short": True,
    }
    service.publish("plan.proposed", "plan-1")
    told = page.get_by_test_id("preferences")
    expect(told).to_contain_text(
        f"Makespan and costs are {makespan_s + 10:.1f} s together; no plan has less than 12.0 s."
    )
    expect(told).to_contain_text("Not every promising choice was tried.")
    expect(told.locator("li")).to_have_text(
        [
            "kept: preferably avoiding bay_3",
            f"not kept, at a cost of 10.0 s: preferably without yard_1 ({why})",
        ]
    )


def test_a_sentence_shows_what_it_prefers_and_what_of_it_cannot_be_kept(
    page: Page, service: FakeService
) -> None:
    page.get_by_test_id("goal-text").fill("park yard_1 preferably without yard_1 and charged")
    expect(page.get_by_test_id("goal-terms").locator("li")).to_have_text(
        [
            "preferably without yard_1: cost 20 s; it cannot be kept: near(yard_1, home) needs yard_1",
            "preferably only with robots of battery >= 0.4: cost 60 s",
        ]
    )


def test_a_goal_that_is_not_to_be_true_yet_says_for_how_long(page: Page, service: FakeService) -> None:
    service.propose(GOAL, not_before_at_s=service.time_s + 20.0)
    expect(page.get_by_test_id("goal-due")).to_have_text("not before 20.0 s from now")
    service.time_s += 25.0
    expect(page.get_by_test_id("goal-due")).to_have_count(0)


@pytest.mark.parametrize(
    ("proven", "complete", "words"),
    [
        (True, True, "No plan keeps these constraints together, without any one of them there is one:"),
        (False, True, "No plan that keeps these constraints together was found in time, without any"),
        (True, False, "No plan keeps these constraints together; there was no time to look for fewer:"),
    ],
)
def test_the_constraints_that_leave_no_plan_are_listed(
    page: Page, service: FakeService, proven: bool, complete: bool, words: str
) -> None:
    constraints = ["without yard_2", "keeping empty: bay_3"]
    conflict = {"constraints": constraints, "proven": proven, "complete": complete}
    service.propose(
        GOAL, state="unsolvable", outcome="unsolvable", plan_id=None, reason="", conflict=conflict
    )
    shown = page.get_by_test_id("goal-conflict")
    expect(shown).to_contain_text(words)
    expect(shown.locator("li")).to_have_text(constraints)


@pytest.mark.parametrize(("outcome", "word"), [("unsolvable", "unsolvable"), ("timed_out", "no plan found")])
def test_only_what_is_proven_is_called_unsolvable(
    page: Page, service: FakeService, outcome: str, word: str
) -> None:
    service.propose(GOAL, state="unsolvable", outcome=outcome, plan_id=None, reason="no robot reaches bay_1")
    expect(page.get_by_test_id("goal-state")).to_have_text(word)
    expect(page.get_by_test_id("goal-reason")).to_have_text("no robot reaches bay_1")


def test_a_packet_says_whose_action_it_waits_for(page: Page, service: FakeService) -> None:
    service.propose(GOAL)
    service.approve("plan-1")
    packet: dict[str, Any] = service.missions["mission-1"]["progress"][1]["packets"][1]
    packet["waits_for"] = ["a4 of yard_1"]
    service.publish("mission.running", "mission-1")
    expect(page.get_by_test_id("mission")).to_contain_text("waits for a4 of yard_1")
