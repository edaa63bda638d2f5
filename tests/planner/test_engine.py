"""The engine on the sample store (MACTA §5)."""

import pytest

from planner import (
    Fact,
    FastDownwardEngine,
    KnowledgeBase,
    PlanNet,
    PlanningProblem,
    PlanningResult,
    PlanningStatus,
    faults_of,
    first_violation,
)
from robots.world import load_world
from tests.planner.store import inside, store_problem

BAYS = [f"bay_{number}" for number in range(1, 13)]
LIMIT_S = 100.0  # generous: the machine may be busy


def solved(engine: FastDownwardEngine, base: KnowledgeBase, problem: PlanningProblem) -> PlanNet:
    """The plan-net, checked once more from outside."""
    result = engine.plan(problem, time_limit_s=LIMIT_S)
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert faults_of(result.plan_net, problem.facts, base) == []
    assert first_violation(result.plan_net, problem.facts, problem.objects, base) is None
    return result.plan_net


@pytest.mark.parametrize("bay", BAYS)
def test_a_sample_at_a_door_can_be_stored_in_each_bay(
    engine: FastDownwardEngine, knowledge_base: KnowledgeBase, bay: str
) -> None:
    plan_net = solved(
        engine, knowledge_base, store_problem([inside("sample_1", bay)], samples={"sample_1": "door_1"})
    )
    store_robot = "store_1" if bay in BAYS[:6] else "store_2"
    assert {"DOCK", "TRANSPORT", "RELEASE2"} <= {action.tag for action in plan_net.of_robot(store_robot)}
    assert len(plan_net.actions) == 8


@pytest.mark.parametrize("bay", BAYS)
def test_a_sample_in_each_bay_can_be_retrieved_to_a_door(
    engine: FastDownwardEngine, knowledge_base: KnowledgeBase, bay: str
) -> None:
    plan_net = solved(
        engine, knowledge_base, store_problem([inside("sample_1", "door_2")], samples={"sample_1": bay})
    )
    assert len(plan_net.robots) == 2


def test_the_same_problem_gives_the_same_plan_net(engine: FastDownwardEngine) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    one, other = (engine.plan(problem, time_limit_s=LIMIT_S).plan_net for _ in range(2))
    assert one == other


TWO_GOALS = {
    "stores over one interchange": (
        {"sample_1": "door_1", "sample_2": "door_2"},
        {"sample_1": "bay_1", "sample_2": "bay_2"},
    ),
    "stores into both aisles": (
        {"sample_1": "door_1", "sample_2": "door_2"},
        {"sample_1": "bay_7", "sample_2": "bay_2"},
    ),
    "a store and a retrieval over one interchange": (
        {"sample_1": "door_1", "sample_2": "bay_2"},
        {"sample_1": "bay_1", "sample_2": "door_1"},
    ),
    "an exchange of two bays' aisles": (
        {"sample_1": "bay_1", "sample_2": "bay_7"},
        {"sample_1": "bay_8", "sample_2": "bay_2"},
    ),
    "a retrieval into the place of a store": (
        {"sample_1": "door_1", "sample_2": "bay_2"},
        {"sample_1": "bay_2", "sample_2": "door_1"},
    ),
}


@pytest.mark.parametrize("story", TWO_GOALS)
def test_two_goals_at_once_do_not_clash(
    engine: FastDownwardEngine, knowledge_base: KnowledgeBase, story: str
) -> None:
    samples, targets = TWO_GOALS[story]
    problem = store_problem([inside(sample, place) for sample, place in targets.items()], samples=samples)
    solved(engine, knowledge_base, problem)


def test_a_robot_that_stands_in_the_way_makes_way(
    engine: FastDownwardEngine, knowledge_base: KnowledgeBase
) -> None:
    """Neither yard robot is where it is wanted, and each stands where the other must go."""
    problem = store_problem(
        [inside("sample_1", "bay_1")],
        samples={"sample_1": "door_1"},
        robots_at={"yard_1": "interchange_1", "yard_2": "interchange_2"},
    )
    solved(engine, knowledge_base, problem)


def test_a_robot_is_recruited_for_a_reason_that_names_the_others(engine: FastDownwardEngine) -> None:
    result = engine.plan(store_problem([inside("sample_1", "bay_7")]), time_limit_s=LIMIT_S)
    assert result.plan_net is not None
    assert set(result.plan_net.recruitment) == set(result.plan_net.robots) == {"yard_1", "store_2"}
    assert "yard_2 would qualify too" in result.plan_net.recruitment["yard_1"]
    assert "no other robot qualifies" in result.plan_net.recruitment["store_2"]


def refused(engine: FastDownwardEngine, problem: PlanningProblem) -> PlanningResult:
    result = engine.plan(problem, time_limit_s=LIMIT_S)
    assert result.plan_net is None
    return result


def test_a_bay_no_robot_reaches_is_unsolvable_and_named(engine: FastDownwardEngine) -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    gone = {fact for fact in problem.facts if fact.predicate == "reaches" and "bay_7" in fact.args}
    result = refused(
        engine,
        PlanningProblem(
            objects=problem.objects,
            facts=problem.facts - gone,
            goals=problem.goals,
            functions=problem.functions,
        ),
    )
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "no robot that can RELEASE2 reaches bay_7" in result.reason


def test_a_place_that_holds_no_samples_is_unsolvable_and_said_so(engine: FastDownwardEngine) -> None:
    result = refused(engine, store_problem([inside("sample_1", "home_yard_1")]))
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "vacant(home_yard_1) does not hold" in result.reason


def test_a_goal_outside_the_vocabulary_fails_with_the_choices(engine: FastDownwardEngine) -> None:
    result = refused(engine, store_problem([Fact("object_position", ("sample_1", "in", "bay_99"))]))
    assert result.status is PlanningStatus.FAILED
    assert "bay_99" in result.reason
    assert "bay_12" in result.reason


def test_the_processes_are_ended_at_the_time_limit(engine: FastDownwardEngine) -> None:
    problem = store_problem([inside("sample_1", "bay_7"), inside("sample_2", "bay_8")])
    result = engine.plan(problem, time_limit_s=0.05)
    assert result.status is PlanningStatus.TIMED_OUT
    assert result.plan_net is None


def test_an_engine_that_runs_out_of_memory_says_so(knowledge_base: KnowledgeBase) -> None:
    small = FastDownwardEngine(knowledge_base, memory_limit_mb=24)
    result = refused(small, store_problem([inside("sample_1", "bay_7")], world=load_world("sample_store")))
    assert result.status is PlanningStatus.OUT_OF_MEMORY
