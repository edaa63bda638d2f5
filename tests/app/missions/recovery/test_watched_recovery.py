"""A repair while it is planned: operators see how far that is, as they do of a goal's first plan."""

from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.planning.pool.pool import PlanningWorker
from tests.app.missions.recovery.conftest import Follow, Start
from tests.app.planning.fake_engine import make_patient_engine


@pytest.fixture(scope="module")
def worker() -> Iterator[PlanningWorker]:
    worker = PlanningWorker(make_patient_engine)
    worker.warm_up().result(timeout=300)
    yield worker
    worker.close()


def test_a_repair_tells_how_its_planning_goes(
    start: Start, api: TestClient, follow: Follow, service: Service
) -> None:
    mission, _ = start("auto", fails="DOCK", time_limit_s=3)
    ended = follow(mission, "completed", "partially_completed", "failed")
    assert ended["state"] == "completed", ended["reason"]
    events = service.events.since(0)
    begun = next(event.seq for event in events if event.type == "mission.recovery_begun")
    told = [event for event in events if event.type == "goal.progress" and event.seq > begun]
    assert {(event.subject, event.data["engine"]) for event in told} == {(ended["goal_id"], "patient")}
    assert all(event.data["makespan_s"] > event.data["lower_bound_s"] > 0 for event in told)
    assert api.get(f"/v1/goals/{ended['goal_id']}").json()["planning"] is None
