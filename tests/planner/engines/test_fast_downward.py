"""The engine on the sample store (MACTA §5)."""

import pytest

from planner import (
    Fact,
    KnowledgeBase,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
    faults_of,
)
from planner.engines.fast_downward import FastDownwardEngine
from robots.world import load_world
from tests.planner.exploring import first_fault
from tests.planner.store import inside, store_problem

BAYS = [f"bay_{number}" for number in range(1, 13)]
LIMIT_S = 100.0  # generous: the machine may be busy


def solved(engine: FastDownwardEngine, base: KnowledgeBase, problem: PlanningProblem) -> PlanNet:
    """The plan-net, checked once more from outside."""
    result = engine.plan(problem, PlanningRequest(time_limit_s=LIMIT_S))
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.plan_net is not None
    assert faults_of(result.plan_net, problem.facts, base) == []
    assert first_fault(result.plan_net, problem.facts, problem.objects, base) is None
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
    one, other = (engine.plan(problem, PlanningRequest(time_limit_s=LIMIT_S)).plan_net for _ in range(2))
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
    result = engine.plan(store_problem([inside("sample_1", "bay_7")]), PlanningRequest(time_limit_s=LIMIT_S))
    assert result.plan_net is not None
    assert set(result.plan_net.recruitment) == set(result.plan_net.robots) == {"yard_1", "store_2"}
    assert "yard_2 would qualify too" in result.plan_net.recruitment["yard_1"]
    assert "no other robot qualifies" in result.plan_net.recruitment["store_2"]


def refused(engine: FastDownwardEngine, problem: PlanningProblem) -> PlanningResult:
    result = engine.plan(problem, PlanningRequest(time_limit_s=LIMIT_S))
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
    assert "no robot reaches bay_7" in result.reason


def test_a_place_that_holds_no_samples_is_unsolvable_and_said_so(engine: FastDownwardEngine) -> None:
    result = refused(engine, store_problem([inside("sample_1", "home_yard_1")]))
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "home_yard_1 has no room for an object" in result.reason


def test_a_goal_outside_the_vocabulary_fails_with_the_choices(engine: FastDownwardEngine) -> None:
    result = refused(engine, store_problem([Fact("object_position", ("sample_1", "in", "bay_99"))]))
    assert result.status is PlanningStatus.FAILED
    assert "bay_99" in result.reason
    assert "bay_12" in result.reason


def test_the_processes_are_ended_at_the_time_limit(engine: FastDownwardEngine) -> None:
    problem = store_problem([inside("sample_1", "bay_7"), inside("sample_2", "bay_8")])
    result = engine.plan(problem, PlanningRequest(time_limit_s=0.05))
    assert result.status is PlanningStatus.TIMED_OUT
    assert result.plan_net is None


def test_an_engine_that_runs_out_of_memory_says_so(engine: FastDownwardEngine) -> None:
    problem = store_problem([inside("sample_1", "bay_7")], world=load_world("sample_store"))
    result = engine.plan(problem, PlanningRequest(time_limit_s=LIMIT_S, memory_limit_mb=24))
    assert result.plan_net is None
    assert result.status is PlanningStatus.OUT_OF_MEMORY


class Seen(Observer):
    """Sees progress, and wants the best so far once it has seen `enough`."""

    def __init__(self, enough: int = 10_000) -> None:
        self.spans: list[float] = []
        self._enough = enough

    def progress(self, progress: Progress) -> None:
        self.spans.append(progress.makespan_s or 0.0)

    def should_stop(self) -> bool:
        return len(self.spans) >= self._enough


SAMPLES, TARGETS = TWO_GOALS["stores into both aisles"]
TWO_STORES = store_problem(
    [inside("sample_3", "bay_3"), *(inside(sample, place) for sample, place in TARGETS.items())],
    samples={**SAMPLES, "sample_3": "bay_9"},
)


def test_effort_makes_ever_shorter_plans_and_tells_of_them(
    engine: FastDownwardEngine, knowledge_base: KnowledgeBase
) -> None:
    seen = Seen()
    result = engine.plan(TWO_STORES, PlanningRequest(time_limit_s=LIMIT_S, effort_s=5), seen)
    assert result.plan_net is not None, result.reason
    assert faults_of(result.plan_net, TWO_STORES.facts, knowledge_base) == []
    assert seen.spans == sorted(seen.spans, reverse=True)
    assert seen.spans[-1] == result.plan_net.makespan_s


def test_the_best_plan_so_far_is_taken_once_it_is_to_stop(engine: FastDownwardEngine) -> None:
    result = engine.plan(TWO_STORES, PlanningRequest(time_limit_s=LIMIT_S, effort_s=LIMIT_S), Seen(enough=1))
    assert result.plan_net is not None, result.reason
    assert result.planning_s < LIMIT_S


def test_without_its_programs_the_answer_says_how_to_get_them(knowledge_base: KnowledgeBase) -> None:
    missing = FastDownwardEngine(knowledge_base, find_programs=lambda: None)
    result = missing.plan(store_problem([inside("sample_1", "bay_7")]), PlanningRequest())
    assert result.status is PlanningStatus.FAILED
    assert "not installed: fast-downward" in result.reason
    assert "--extra engines" in result.reason
