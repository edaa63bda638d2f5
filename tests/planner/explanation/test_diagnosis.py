"""Why there is no plan, in an operator's words."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from planner import Fact, KnowledgeBase, PlanningProblem
from planner.explanation.diagnosis import why_unsolvable
from tests.planner.store import inside, store_problem

Unwanted = Callable[[Fact], bool]
STORING = store_problem([inside("sample_1", "bay_7")])
FETCHING = store_problem([inside("sample_1", "door_1")], samples={"sample_1": "bay_9"})


def without(problem: PlanningProblem, unwanted: Unwanted) -> PlanningProblem:
    return replace(problem, facts=frozenset(fact for fact in problem.facts if not unwanted(fact)))


LACKING: dict[str, tuple[PlanningProblem, Unwanted]] = {
    "no robot reaches bay_7": (STORING, lambda f: f.predicate == "reaches" and "bay_7" in f.args),
    "sample_1 is in bay_9: no robot reaches bay_9": (
        FETCHING,
        lambda f: f.predicate == "reaches" and "bay_9" in f.args,
    ),
    "no robot that reaches bay_9 can DOCK": (FETCHING, lambda f: f == Fact("can", ("store_2", "DOCK"))),
    "no robot can DOCK": (FETCHING, lambda f: f.predicate == "can" and f.args[1] == "DOCK"),
    "at best sample_1 is in door_1 or door_2; no robot that reaches door_1 reaches interchange_2": (
        STORING,
        lambda f: f.predicate == "reaches" and f.args[0].startswith("yard") and f.args[1].startswith("inter"),
    ),
    "sample_1 is not in any location": (
        STORING,
        lambda f: f.predicate == "object_position" and f.args[0] == "sample_1",
    ),
    "bay_7 is not clear of robots in aisle_2": (
        STORING,
        lambda f: f.predicate == "clear" and f.args[0] == "bay_7",
    ),
}


@pytest.mark.parametrize("words", LACKING)
def test_what_is_missing_is_said(knowledge_base: KnowledgeBase, words: str) -> None:
    problem, unwanted = LACKING[words]
    assert why_unsolvable(knowledge_base, without(problem, unwanted)) == words


def test_a_place_without_room_is_said_to_have_none(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([inside("sample_1", "home_yard_1")])
    assert why_unsolvable(knowledge_base, problem) == "home_yard_1 has no room for an object"


def test_a_place_that_is_new_to_the_world_is_reached_by_nobody(knowledge_base: KnowledgeBase) -> None:
    goals = (inside("sample_1", "bay_13"), inside("sample_2", "bay_13"))
    problem = replace(STORING, objects={**STORING.objects, "bay_13": "location"}, goals=goals)
    assert why_unsolvable(knowledge_base, problem) == "no robot reaches bay_13"


def test_a_robot_kept_from_a_place_is_reported_with_how_far_it_gets(knowledge_base: KnowledgeBase) -> None:
    problem = replace(STORING, goals=(Fact("robot_position", ("yard_1", "near", "bay_3")),))
    reason = why_unsolvable(knowledge_base, problem)
    assert reason.startswith(
        "at best yard_1 is near door_1, door_2, home_yard_1, interchange_1 or interchange_2; "
    )
    assert reason.endswith("it would take that yard_1 reaches bay_3")


def test_what_contradicts_a_present_fact_is_named_if_nothing_else_helps(
    knowledge_base: KnowledgeBase,
) -> None:
    problem = replace(STORING, goals=(Fact("tracked", ("yard_1", "store_1")),))
    assert why_unsolvable(knowledge_base, problem).endswith("it would take that store_1 is in yard")


@pytest.mark.parametrize("name", ["distance_m", "speed_m_s"])
def test_a_missing_number_is_named(knowledge_base: KnowledgeBase, name: str) -> None:
    kept = {
        (function, args): value
        for (function, args), value in STORING.functions.items()
        if function != name or not {"bay_7", "store_2"} & set(args)
    }
    reason = why_unsolvable(knowledge_base, replace(STORING, functions=kept))
    assert reason.startswith(f"nothing is known of {name}(")


def test_an_effect_that_no_action_intends_is_said_so(knowledge_base: KnowledgeBase) -> None:
    problem = replace(FETCHING, goals=(Fact("vacant", ("bay_9",)),))
    reason = why_unsolvable(knowledge_base, problem)
    assert reason == "no action has the intended effect vacant, it only comes about as a side effect"


def test_several_goals_have_each_their_reason(knowledge_base: KnowledgeBase) -> None:
    goals = (inside("sample_1", "bay_7"), inside("sample_2", "home_yard_2"))
    problem = without(replace(STORING, goals=goals), LACKING["no robot reaches bay_7"][1])
    reason = why_unsolvable(knowledge_base, problem)
    assert reason == "no robot reaches bay_7; home_yard_2 has no room for an object"


def test_goals_that_contradict_each_other_are_named(knowledge_base: KnowledgeBase) -> None:
    goals = (inside("sample_1", "bay_7"), inside("sample_2", "bay_7"))
    reason = why_unsolvable(knowledge_base, replace(STORING, goals=goals))
    assert reason == "sample_1 is in bay_7 or sample_2 is in bay_7, not both"


def test_without_a_reason_no_goal_is_blamed(knowledge_base: KnowledgeBase) -> None:
    goals = (inside("sample_1", "bay_7"), inside("sample_2", "bay_8"))
    reason = why_unsolvable(knowledge_base, replace(STORING, goals=goals))
    assert reason == "no plan exists from the present facts for all goals together"
