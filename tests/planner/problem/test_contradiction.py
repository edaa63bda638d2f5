"""Goals of which at most one can be true at a time."""

from dataclasses import replace

import pytest

from planner import Fact, KnowledgeBase, PlanningRequest, PlanningStatus
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.problem.contradiction import contradicting_goals
from tests.planner.store import inside, store_problem

STORE = store_problem([])


def near(robot: str, place: str) -> Fact:
    return Fact("robot_position", (robot, "near", place))


@pytest.mark.parametrize(
    ("one", "other", "contradict"),
    [
        (inside("sample_1", "bay_7"), inside("sample_2", "bay_7"), True),
        (inside("sample_1", "bay_7"), inside("sample_1", "bay_8"), True),
        (inside("sample_1", "bay_7"), inside("sample_1", "store_2"), True),
        (inside("sample_1", "bay_7"), inside("sample_2", "bay_8"), False),
        (near("yard_1", "door_1"), near("yard_2", "door_1"), True),
        (near("yard_1", "door_1"), near("yard_1", "door_2"), True),
        (near("yard_1", "interchange_1"), near("store_1", "interchange_1"), False),
        (near("yard_1", "door_1"), inside("sample_1", "door_1"), False),
        (Fact("tracked", ("yard_1", "yard_2")), Fact("tracked", ("yard_1", "store_1")), False),
    ],
)
def test_what_holds_one_at_a_time_contradicts(
    knowledge_base: KnowledgeBase, one: Fact, other: Fact, contradict: bool
) -> None:
    found = contradicting_goals(knowledge_base, replace(STORE, goals=(one, other)))
    assert found == (((one, other),) if contradict else ())


def test_that_goals_contradict_each_other_is_a_proof(knowledge_base: KnowledgeBase) -> None:
    goals = (inside("sample_1", "bay_7"), near("yard_1", "door_1"), near("yard_2", "door_1"))
    result = HierarchicalEngine(knowledge_base).plan(replace(STORE, goals=goals), PlanningRequest())
    assert result.status is PlanningStatus.UNSOLVABLE
    assert result.reason == "yard_1 is near door_1 or yard_2 is near door_1, not both"
