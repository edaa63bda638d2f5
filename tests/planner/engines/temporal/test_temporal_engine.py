"""Temporal planners on the sample store (MACTA §5), where they are installed."""

from dataclasses import replace
from pathlib import Path

import pytest

from planner import (
    Fact,
    KnowledgeBase,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningStatus,
    Progress,
    faults_of,
)
from planner.engines.temporal import Aries, Lpg, Solver, TemporalEngine, lpg
from planner.engines.temporal.best_plan import BestPlan, Step, sequence_of
from planner.interchange.pddl import Form, PddlTask
from planner.native_process import Limits, ProcessEnd
from tests.planner.store import inside, store_problem

LIMIT_S = 100.0  # generous: the machine may be busy
STORE = store_problem([inside("sample_1", "bay_7")], samples={"sample_1": "door_1"})


class Seen(Observer):
    def __init__(self) -> None:
        self.spans: list[float | None] = []

    def progress(self, progress: Progress) -> None:
        self.spans.append(progress.makespan_s)


def of(solver: Solver, knowledge_base: KnowledgeBase) -> TemporalEngine:
    if not solver.is_installed:
        pytest.skip(f"{solver.name} is not installed")
    return TemporalEngine(knowledge_base, solver)


@pytest.mark.parametrize("solver", [Lpg(), Aries()], ids=lambda solver: solver.name)
def test_a_sample_is_stored_by_a_valid_plan_net_that_is_reported(
    solver: Solver, knowledge_base: KnowledgeBase
) -> None:
    seen = Seen()
    request = PlanningRequest(time_limit_s=LIMIT_S, effort_s=0.0)
    result = of(solver, knowledge_base).plan(STORE, request, seen)
    assert result.status is PlanningStatus.SOLVED, result.reason
    assert result.engine == solver.name
    assert result.plan_net is not None
    assert faults_of(result.plan_net, STORE.facts, knowledge_base) == []
    assert all(ordering.kept_by is not None for ordering in result.plan_net.orderings)
    assert seen.spans[-1] == result.plan_net.makespan_s


def test_two_goals_that_share_an_interchange_are_planned_by_lpg(knowledge_base: KnowledgeBase) -> None:
    samples = {"sample_1": "door_1", "sample_2": "door_2"}
    problem = store_problem([inside("sample_1", "bay_1"), inside("sample_2", "bay_2")], samples=samples)
    result = of(Lpg(), knowledge_base).plan(problem, PlanningRequest(time_limit_s=LIMIT_S))
    assert result.plan_net is not None, result.reason
    assert faults_of(result.plan_net, problem.facts, knowledge_base) == []


def test_a_goal_out_of_reach_is_proven_unsolvable(knowledge_base: KnowledgeBase) -> None:
    gone = {fact for fact in STORE.facts if fact.predicate == "reaches" and "bay_7" in fact.args}
    problem = replace(STORE, facts=STORE.facts - gone)
    result = of(Lpg(), knowledge_base).plan(problem, PlanningRequest(time_limit_s=LIMIT_S))
    assert result.status is PlanningStatus.UNSOLVABLE
    assert "bay_7" in result.reason


def test_lpg_is_ended_at_the_time_limit(
    knowledge_base: KnowledgeBase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # LPG itself may crash where it does not find a plan, so something that surely goes on stands for it.
    endless = tmp_path / "lpg"
    endless.write_text("#!/bin/sh\nexec sleep 600\n")
    endless.chmod(0o755)
    monkeypatch.setattr(lpg, "binary", lambda: endless)
    result = of(Lpg(), knowledge_base).plan(STORE, PlanningRequest(time_limit_s=1.0))
    assert result.status is PlanningStatus.TIMED_OUT
    assert "does not" not in result.reason


class Scripted:
    """A solver that comes up with given schedules."""

    name = "scripted"
    is_installed = True

    def __init__(self, *schedules: tuple[Step, ...], ended: ProcessEnd | None = None) -> None:
        self._schedules = schedules
        self._ended = ended or ProcessEnd(code=0, output="")

    def run(self, folder: Path, limits: Limits, seed: int, best: BestPlan) -> ProcessEnd:
        for schedule in self._schedules:
            best.take(schedule)
        return self._ended


def step(start: float, operator: str, *objects: str) -> Step:
    return Step(start=start, duration=5, operator=operator, objects=objects)


@pytest.mark.parametrize(
    ("ended", "status"),
    [
        (ProcessEnd(code=None, output=""), PlanningStatus.TIMED_OUT),
        (ProcessEnd(code=1, output="out of memory"), PlanningStatus.OUT_OF_MEMORY),
        (ProcessEnd(code=0, output=""), PlanningStatus.NOT_FOUND),
        (ProcessEnd(code=7, output="oh\ndear"), PlanningStatus.FAILED),
        (ProcessEnd(code=-11, output=""), PlanningStatus.FAILED),
    ],
)
def test_the_end_without_a_plan_says_how(
    knowledge_base: KnowledgeBase, ended: ProcessEnd, status: PlanningStatus
) -> None:
    result = TemporalEngine(knowledge_base, Scripted(ended=ended)).plan(STORE, PlanningRequest())
    assert result.status is status
    assert result.reason


def test_a_faulty_schedule_is_passed_over_with_the_reason(knowledge_base: KnowledgeBase) -> None:
    wrong = (step(0, "dock", "sample_1", "yard_1", "door_1"),)
    result = TemporalEngine(knowledge_base, Scripted(wrong)).plan(STORE, PlanningRequest())
    assert result.status is PlanningStatus.NOT_FOUND
    assert "robot_position(yard_1, near, door_1)" in result.reason


def test_a_solver_that_is_not_installed_says_how_to_get_it(knowledge_base: KnowledgeBase) -> None:
    missing = Scripted()
    missing.is_installed = False
    result = TemporalEngine(knowledge_base, missing).plan(STORE, PlanningRequest())
    assert result.status is PlanningStatus.FAILED
    assert "--extra engines" in result.reason


def test_a_fact_outside_the_vocabulary_fails_with_the_choices(knowledge_base: KnowledgeBase) -> None:
    problem = store_problem([Fact("object_position", ("sample_1", "in", "bay_99"))])
    result = TemporalEngine(knowledge_base, Scripted()).plan(problem, PlanningRequest())
    assert result.status is PlanningStatus.FAILED
    assert "bay_99" in result.reason


def test_a_schedule_becomes_a_sequence_by_its_starts(knowledge_base: KnowledgeBase) -> None:
    near = Fact("robot_position", ("yard_1", "near", "door_1"))
    problem: PlanningProblem = store_problem([near])
    task = PddlTask(knowledge_base, problem, Form.TEMPORAL)
    schedule = (
        step(9, "navigate", "yard_1", "door_2", "door_1", "yard"),
        step(0, "navigate", "yard_1", "home_yard_1", "door_2", "yard"),
    )
    places = [action.arguments["ref2"] for action in sequence_of(task, schedule)]
    assert places == ["door_2", "door_1"]
