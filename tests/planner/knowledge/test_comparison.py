"""Quantities of a knowledge base, and pre-conditions that compare them with numbers."""

from dataclasses import replace
from pathlib import Path

import pytest

from planner import (
    Fact,
    KnowledgeBase,
    KnowledgeBaseError,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    faults_of,
    merge_knowledge_bases,
    shipped_knowledge_base,
)
from planner.engines.registry import engine_named
from planner.explanation.diagnosis import why_unsolvable
from tests.planner.store import store_problem

LOOKING = """\
predicates:
  inspected:
    arguments: {location: location}
    phrase: "{location} was inspected"
quantities:
  warmth:
    arguments: {location: location}
    unit: degrees
    range: [-50, null]
actions:
  - identifier: 1
    name: LOOK
    parameters: [{name: robot, type: robot}, {name: ref, type: location}]
    agents: [robot]
    preconditions: ["robot_position(robot, near, ref)", "can(robot, TRACK)", "battery(robot) >= 0.3"]
    delete: []
    intended_effects: ["inspected(ref)"]
    other_effects: []
    duration: 4
    description: "{robot} look at {ref}"
"""
GOAL = Fact("inspected", ("door_1",))


def looking(folder: Path, old: str = "", new: str = "") -> KnowledgeBase:
    path = folder / "looking.yaml"
    assert old in LOOKING
    path.write_text(LOOKING.replace(old, new))
    return merge_knowledge_bases([shipped_knowledge_base(), path])


def problem(base: KnowledgeBase, **batteries: float) -> PlanningProblem:
    numbers = {("battery", (robot,)): level for robot, level in batteries.items()}
    plain = store_problem([GOAL])
    others = {fact for fact in plain.facts if "TRACK" in fact.args and fact.args[0] not in batteries}
    return replace(plain, facts=(plain.facts - others) | base.compared(numbers), numbers=numbers)


def test_only_robots_whose_number_suffices_do_the_action(tmp_path: Path) -> None:
    base = looking(tmp_path)
    asked = problem(base, yard_1=0.29, yard_2=0.3)
    result = engine_named("macta", base).plan(asked, PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None
    assert [one.agents for one in result.plan_net.actions if one.tag == "LOOK"] == [("yard_2",)]
    assert not faults_of(result.plan_net, asked.facts, base)


def test_a_plan_with_a_robot_whose_number_is_too_small_is_faulty(tmp_path: Path) -> None:
    base = looking(tmp_path)
    asked = problem(base, yard_1=0.9)
    net = engine_named("macta", base).plan(asked, PlanningRequest(effort_s=0.0)).plan_net
    assert net is not None
    low = replace(asked, facts=asked.facts - {Fact("battery_at_least_0_3", ("yard_1",))})
    assert any("battery_at_least_0_3(yard_1)" in fault for fault in map(str, faults_of(net, low.facts, base)))


def test_a_goal_out_of_reach_names_the_number_that_is_needed_and_the_one_there_is(tmp_path: Path) -> None:
    base = looking(tmp_path)
    asked = problem(base, yard_2=0.12)
    result = engine_named("macta", base).plan(asked, PlanningRequest())
    assert result.status is PlanningStatus.UNSOLVABLE
    assert result.reason == "LOOK needs battery(yard_2) >= 0.3; it is 0.12"


def test_the_numbers_of_all_robots_that_could_do_it_are_named(tmp_path: Path) -> None:
    base = looking(tmp_path)
    asked = problem(base, yard_1=0.1, yard_2=0.12)
    assert why_unsolvable(base, asked) == (
        "LOOK needs battery(robot) >= 0.3; it is 0.1 for yard_1 and 0.12 for yard_2"
    )


def test_a_number_that_nobody_has_told_is_not_known(tmp_path: Path) -> None:
    base = looking(tmp_path)
    asked = replace(problem(base, yard_2=0.12), numbers={})
    assert why_unsolvable(base, asked) == "LOOK needs battery(yard_2) >= 0.3; it is not known"


@pytest.mark.parametrize(
    ("sign", "holding"), [(">=", {0.3, 0.4}), (">", {0.4}), ("<=", {0.2, 0.3}), ("<", {0.2})]
)
def test_each_sign_compares_as_written(tmp_path: Path, sign: str, holding: set[float]) -> None:
    base = looking(tmp_path, ">=", sign)
    levels = {0.2, 0.3, 0.4}
    held = {level for level in levels if base.compared({("battery", ("yard_1",)): level})}
    assert held == holding


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "battery(robot)",
            "batery(robot)",
            "unknown quantity 'batery'; choices: battery, load, samples, warmth",
        ),
        ("battery(robot)", "battery(ref)", "ref is a location, robot of battery a robot"),
        ("battery(robot)", "battery(robot, ref)", "battery takes (robot), not (robot, ref)"),
        (">= 0.3", ">= 30", "battery is 0 to 1, it cannot be 30"),
        (">= 0.3", ">= much", "'much' is no number"),
        (">= 0.3", "== 0.3", "is not of the form quantity(term, …) >= number"),
        ("battery(robot) >= 0.3", "warmth(ref) < -51", "warmth is at least -50, it cannot be -51"),
        ("range: [-50, null]", "range: [5, 1]", "5 is more than 1"),
        ("  warmth:", "  reaches:", "reaches is a predicate already"),
        ("unit: degrees", "phrase: '{warmth}'", "unknown argument 'warmth'; choices: location, value"),
        ("unit: degrees", "counts: vacant(bay_1)", "unknown location 'bay_1'"),
        ("unit: degrees", "counts: object_position(any, on, location)", "unknown relation 'on'"),
        ("unit: degrees", "counts: vacant(any, any)", "vacant takes (location), not (any, any)"),
        ("unit: degrees", "counts: 'vacant(any) > 3'", "'vacant(any) > 3' is not of the form"),
        ('["inspected(ref)"]', '["inspected(ref)", "battery(robot) >= 0.3"]', "is not of the form"),
    ],
)
def test_what_is_wrong_with_a_number_is_named_with_the_choices(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    with pytest.raises(KnowledgeBaseError) as refused:
        looking(tmp_path, old, new)
    assert said in str(refused.value)


def test_two_files_may_not_define_a_quantity_differently(tmp_path: Path) -> None:
    with pytest.raises(KnowledgeBaseError, match="battery is defined differently"):
        looking(
            tmp_path,
            "  warmth:\n    arguments: {location: location}",
            "  battery:\n    arguments: {robot: robot}",
        )
