"""Durations times what was learned of them, in the one place where they are computed."""

from dataclasses import replace

import pytest

from planner import (
    KnowledgeBase,
    KnowledgeBaseError,
    PlanningRequest,
    read_knowledge_base,
)
from planner.engines.fast_downward import FastDownwardEngine
from planner.knowledge import DURATION_SCALE, scale_term
from tests.planner.knowledge.test_knowledge_base import FUNCTIONS, OBJECTS, shipped
from tests.planner.store import inside, store_problem

NAVIGATE = {
    "robots": "yard_1",
    "rel1": "near",
    "ref1": "door_1",
    "rel2": "near",
    "ref2": "bay_7",
    "area": "yard",
}


def navigate_s(knowledge_base: KnowledgeBase, **scales: float) -> float:
    learned = {scale_term(tag, 1): factor for tag, factor in scales.items()}
    action = knowledge_base.ground("NAVIGATE", NAVIGATE, {**FUNCTIONS, **learned}, objects=OBJECTS)
    return action.duration_s


def test_a_learned_factor_multiplies_the_durations_of_its_action_only(knowledge_base: KnowledgeBase) -> None:
    assert navigate_s(knowledge_base, NAVIGATE=1.5) == pytest.approx(1.5 * navigate_s(knowledge_base))
    assert navigate_s(knowledge_base, DOCK=1.5) == navigate_s(knowledge_base)


def test_a_factor_for_a_team_of_two_does_not_touch_one_robot_alone(knowledge_base: KnowledgeBase) -> None:
    learned = {**FUNCTIONS, scale_term("NAVIGATE", 2): 3.0}
    alone = knowledge_base.ground("NAVIGATE", NAVIGATE, learned, objects=OBJECTS)
    assert alone.duration_s == navigate_s(knowledge_base)


def test_the_plan_is_made_with_the_factors(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    slow = replace(problem, functions={**problem.functions, scale_term("DOCK", 1): 4.0})
    engine = FastDownwardEngine(knowledge_base)
    usual, longer = (engine.plan(p, PlanningRequest(time_limit_s=30)).plan_net for p in (problem, slow))
    assert usual is not None
    assert longer is not None
    docks = [action.duration_s for action in longer.actions if action.tag == "DOCK"]
    assert docks == [10.0] * len(docks)
    assert longer.makespan_s == pytest.approx(usual.makespan_s + 7.5 * len(docks), abs=0.1)


def test_no_knowledge_base_may_take_the_name() -> None:
    text = shipped().replace("  speed_m_s: [robot]\n", f"  speed_m_s: [robot]\n  {DURATION_SCALE}: [robot]\n")
    with pytest.raises(KnowledgeBaseError, match=r"functions.duration_scale.*choose another name"):
        read_knowledge_base(text, "own.yaml")
