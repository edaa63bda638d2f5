"""A goal whose planning two processes are at: one took the other for dead, or both were to look what became free."""

from collections.abc import Callable
from concurrent.futures import Future
from queue import Queue
from typing import Any

import pytest
from dbos import DBOS
from fastapi.testclient import TestClient

from app.composition import Service
from app.store import WorldRow
from app.workflows import PLAN_GOAL, PLANNING
from planner import UNOBSERVED, Observer, PlanningProblem, PlanningRequest, PlanningResult, PlanningStatus
from tests.app.sample_store import Store
from tests.app.scripted import InProcessWorker
from tests.databases import ON_BOTH

Answer = Future[PlanningResult]


class EngineAnsweredByHand:
    """Whoever asks for a plan waits until the test has answered."""

    name = "scripted"

    def __init__(self) -> None:
        self.asked: Queue[Answer] = Queue()

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        answer: Answer = Future()
        self.asked.put(answer)
        return answer.result(timeout=120)


@pytest.fixture
def engine() -> EngineAnsweredByHand:
    return EngineAnsweredByHand()


@pytest.fixture
def worker(engine: EngineAnsweredByHand) -> InProcessWorker:
    return InProcessWorker(engine)


@ON_BOTH
def test_the_answer_to_a_question_of_before_does_not_count(
    service: Service, engine: EngineAnsweredByHand, api: TestClient, follow: Callable[..., dict[str, Any]]
) -> None:
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()["id"]
    before = engine.asked.get(timeout=60)
    with service.database.write() as session:  # something becomes free, and another process plans the goal
        session.get_one(WorldRow, "sample_store").releases += 1
        service.core.workflows.start(session, PLANNING, PLAN_GOAL, "another", goal)
    now = engine.asked.get(timeout=60)
    before.set_result(PlanningResult(status=PlanningStatus.UNSOLVABLE, engine="scripted", planning_s=0.0))
    DBOS.retrieve_workflow(f"{goal}:1").get_result()
    assert follow(f"/v1/goals/{goal}", "planning", "unsolvable")["state"] == "planning"
    now.set_result(
        PlanningResult(
            status=PlanningStatus.SOLVED, engine="scripted", planning_s=0.0, plan_net=Store().store_sample_1()
        )
    )
    follow(f"/v1/goals/{goal}", "planned")
