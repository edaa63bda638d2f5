"""Things that lie where others are to go: each moves once its room is free, one of a circle by a room aside."""

from dataclasses import replace

import pytest

from benchmarks.planner.instances import FAMILIES
from planner import Fact, PlanningProblem, PlanningRequest, load_knowledge_base
from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS
from planner.engines.hierarchical.fragments.fragment import Fragment, Fragments
from planner.engines.hierarchical.legs.goal_groups import Goals, Groups
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.rearrangement import Rearranged, Rearrangement
from planner.engines.hierarchical.rooms import Rooms
from tests.planner.engines.hierarchical.judging import planned
from tests.planner.engines.hierarchical.worlds import Store
from tests.planner.store import inside

BASE = load_knowledge_base()


def rearranged(problem: PlanningProblem) -> Rearranged | None:
    classified = ClassifiedProblem(BASE, problem)
    fragments = Fragments(BASE)

    def find(facts: frozenset[Fact], goals: Goals, *, levels: int = ALL_LEVELS) -> tuple[Fragment, ...]:
        return fragments.of(replace(problem, facts=facts)).alternatives(goals, levels=levels)

    return Rearrangement(classified, Groups(classified), find).found()


def vacant(place: str) -> Fact:
    return Fact("vacant", (place,))


def test_the_room_of_a_thing_is_what_its_leaving_brings_about() -> None:
    problem = FAMILIES["full"](6, 0).problem(BASE)
    classified = ClassifiedProblem(BASE, problem)
    rooms = Rooms(classified, Groups(classified))
    robot = min(classified.agents)
    assert rooms.of(inside("sample_1", "bay_3")) == {vacant("bay_3")}
    assert rooms.of(inside("sample_1", robot)) == frozenset()
    assert rooms.of(Fact("robot_position", (robot, "near", "bay_3"))) == frozenset()


@pytest.mark.parametrize(
    ("family", "samples", "seed"),
    [("relocation", 4, 0), ("swap", 4, 1), ("blocked", 2, 0), ("full", 6, 1), ("rearranged", 16, 0)],
)
def test_each_move_takes_up_rooms_that_are_free_by_then(family: str, samples: int, seed: int) -> None:
    problem = FAMILIES[family](samples, seed).problem(BASE)
    found = rearranged(problem)
    assert found is not None
    state = set(problem.facts)
    begun: set[int] = set()
    for move in found.moves:
        assert move.task in begun or move.first == 0, "a task begins with its first action"
        begun.add(move.task)
        for action in move.actions[move.first : move.last]:
            needed = {
                fact for fact in action.preconditions if fact.predicate in ("vacant", "object_position")
            }
            assert needed <= state, f"{action} needs {needed - state}"
            state = state - set(action.deletes) | set(action.effects)
    assert state.issuperset(problem.goals)


def test_only_tasks_in_a_circle_are_put_aside() -> None:
    found = rearranged(FAMILIES["relocation"](4, 0).problem(BASE))
    assert found is not None
    assert len(found.moves) == 4
    found = rearranged(FAMILIES["swap"](4, 1).problem(BASE))
    assert found is not None
    assert len(found.moves) == 6


def test_what_lies_in_nobodys_way_is_not_rearranged() -> None:
    problem = Store().problem([inside("sample_1", "bay_0_1")], {"sample_1": "door_0", "sample_2": "bay_0_2"})
    assert rearranged(problem) is None


def test_what_has_reached_its_goal_is_not_put_aside() -> None:
    """The only way to the aisle is where sample_1 ends; a second fragment of it would begin at its first place."""
    goals = [inside("sample_1", "interchange_0_0"), inside("sample_2", "bay_0_0")]
    problem = Store(aisles=1).problem(goals, {"sample_1": "bay_0_0", "sample_2": "door_0"})
    found = rearranged(problem)
    moves = found.moves if found is not None else []
    ended = dict.fromkeys((move.task for move in moves), 0)
    for move in moves:
        assert move.first == ended[move.task], "a task begins again"
        ended[move.task] = move.last


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_all_bays_full_are_rearranged(seed: int) -> None:
    planned(BASE, FAMILIES["full"](6, seed).problem(BASE))


@pytest.mark.parametrize("seed", [0, 1])
def test_a_large_store_is_rearranged_over_all_its_aisles(seed: int) -> None:
    problem = FAMILIES["rearranged"](64, seed).problem(BASE)
    planned(BASE, problem, PlanningRequest(effort_s=0.0, time_limit_s=30))
