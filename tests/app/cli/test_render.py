"""A plan-net in the terminal."""

from dataclasses import replace

import pytest
from rich.console import Console

from app.cli.render import show_plan
from app.domain.plan_document import DifferenceBody, PlanBody, RepairsBody
from app.domain.tender_document import LegBody, TenderBody
from planner.repair import Course
from tests.app.sample_store import Store, said

STORE = Store()


def shown(plan: PlanBody) -> str:
    console = Console(width=100)
    with console.capture() as capture:
        show_plan(console, plan)
    return " ".join(capture.get().split())


def test_the_critical_path_and_what_the_plan_takes_are_shown() -> None:
    net = replace(STORE.store_sample_1(), recruitment={"yard_1": "can NAVIGATE"})
    plan = PlanBody.of_plan_net(net, STORE.base, engine="by hand")
    text = shown(plan)
    assert f"Critical path: {' → '.join(net.critical_path)}" in text
    assert f"{net.makespan_s:.0f} s, {net.distance_m:.0f} m, {net.energy_j / 1000:.1f} kJ" in text
    drives = sum(action.distance_m for action in net.of_robot("yard_1"))
    assert f"yard_1 ({drives:.0f} m, " in text


def test_a_long_critical_path_is_shortened_in_the_middle() -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    text = shown(plan.model_copy(update={"critical_path": tuple(f"a{n}" for n in range(1, 31))}))
    assert "a5 → a6 → (18 more) → a25 → a26" in text


def test_the_phases_of_an_action_are_told_apart() -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    first, second = (plan.actions[0].model_copy(update={"phase": n, "phases": 2}) for n in (1, 2))
    text = shown(plan.model_copy(update={"actions": (first, second, *plan.actions[1:])}))
    assert text.count("(phase 1 of 2)") == text.count("(phase 2 of 2)") == 1


@pytest.mark.parametrize(
    ("bound_s", "words"),
    [
        (50.0, "50 s (no plan is quicker), 5 m"),
        (40.0, "50 s (at most 25 % over the quickest possible, 40 s), 5 m"),
        (0.0, "Expected to take 50 s, 5 m"),
        (None, "Expected to take 50 s, 5 m"),
    ],
)
def test_it_is_stated_how_far_a_plan_may_be_from_the_best(bound_s: float | None, words: str) -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    figures = {"makespan_s": 50.0, "distance_m": 5.0, "lower_bound_s": bound_s}
    assert words in shown(plan.model_copy(update=figures))


def test_what_an_action_is_done_to_is_shown_whatever_its_arguments_are_called() -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    load = plan.actions[0].model_copy(
        update={"tag": "LOAD", "arguments": {"c": "crate", "by": "van"}, "agents": ("van",)}
    )
    none = {"distance_m": 0.0, "energy_j": 0.0}
    other = plan.model_copy(update={"actions": (load.model_copy(update=none),), **none, "engine": "x"})
    text = shown(other.model_copy(update={"recruitment": {"van": "can LOAD"}}))
    assert "van LOAD crate" in text
    assert "van: can LOAD" in text
    assert "0 m" not in text


def test_a_goal_after_its_deadline_is_reported() -> None:
    net = STORE.store_sample_1()
    late = PlanBody.of_plan_net(replace(net, late={net.goals[0]: 12.0}), STORE.base)
    assert "in(sample_1, bay_7) comes 12 s after its deadline" in shown(late)


def test_what_a_repaired_plan_differs_in_is_reported() -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    assert "Repairs" not in shown(plan)
    words = ("7 of 8 actions kept, ends 7 s later", "new: yard_2 goes to door_1")
    difference = DifferenceBody(
        kept={}, reassigned={}, dropped=(), added=("a1",), shifted={}, later_s=7.0, words=words
    )
    repairs = RepairsBody(plan_id="plan-1", course=Course.MENDED, difference=difference)
    text = shown(plan.model_copy(update={"repairs": repairs}))
    assert f"Repairs plan-1 (mended): {words[0]} {words[1]}" in text


def test_who_is_awarded_which_leg_and_why_is_shown() -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    leg = LegBody(
        id="leg_1",
        goal=said("in(sample_1, bay_7)"),
        parts=(),
        team=("yard_1",),
        why="yard_1 asks 30 s, nobody else bids",
    )
    text = shown(plan.model_copy(update={"tender": TenderBody(legs=(leg,))}))
    assert "leg_1, in(sample_1, bay_7), 0 bids: yard_1 asks 30 s, nobody else bids" in text
    central = TenderBody(state="central", reason="no robot has answered the calls in time")
    text = shown(plan.model_copy(update={"tender": central}))
    assert "Planned without awards: no robot has answered the calls in time" in text
