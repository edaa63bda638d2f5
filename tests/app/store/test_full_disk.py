"""The disk is full, or the record may only be read: clients are told to come again, and nothing is lost."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import Engine, event

from app.composition import Service
from app.workflows.steps import STEP_ATTEMPTS
from tests.app.fake_robots import FakeTeam
from tests.waiting import until

LONG = "move sample_4 to door_2" + " " * 900


class Disk:
    """What the database lies on. `why`: empty while it can be written, `full`, or `read-only`."""

    def __init__(self, *engines: Engine) -> None:
        self.why = ""
        for engine in engines:
            event.listen(engine, "checkout", self._prepare)

    def _prepare(self, connection: Any, *_: object) -> None:
        pages = 1 if self.why == "full" else 2**31  # fewer than there are already: no more than there are
        connection.execute(f"PRAGMA max_page_count={pages}")
        connection.execute(f"PRAGMA query_only={int(self.why == 'read-only')}")


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever waits for the database tries again soon."""
    monkeypatch.setattr("app.workflows.steps.UNAVAILABLE_RETRY_S", 0.05)
    monkeypatch.setattr("app.agents.agent_models.DELIVER_S", 0.05)


@pytest.fixture
def disk(service: Service) -> Iterator[Disk]:
    workflows = service.core.workflows
    disk = Disk(service.database.engine, workflows._dbos._sys_db.engine, workflows._connected._sys_db.engine)
    yield disk
    disk.why = ""


def refused(api: TestClient) -> dict[str, Any]:
    """What is said to a goal once there is no room for it; pages that are half empty take a few."""
    for number in range(200):
        answer = api.post("/v1/goals", json={"text": LONG}, headers={"idempotency-key": str(number)})
        if answer.status_code != 202:
            assert answer.status_code == 503, answer.text
            assert int(answer.headers["retry-after"]) > 0
            return answer.json()  # type: ignore[no-any-return]
    raise AssertionError("all were taken")


@pytest.mark.parametrize(("why", "said"), [("full", "full"), ("read-only", "readonly")])
def test_a_mission_goes_on_once_there_is_room_again(
    why: str,
    said: str,
    disk: Disk,
    api: TestClient,
    team: FakeTeam,
    follow: Callable[..., dict[str, Any]],
    caplog: pytest.LogCaptureFixture,
) -> None:
    team.faults.stuck.add("store_2")
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()["id"]
    mission = follow(f"/v1/goals/{goal}", "committed")["mission_id"]
    follow(f"/v1/missions/{mission}", "running")
    disk.why = why
    problem = refused(api)
    assert problem["type"] == "urn:macta:problem:record-not-writable"
    assert said in problem["detail"]
    team.faults.stuck.clear()
    # Workflow or agent models: whichever has something to record tries again more often than a step that fails.
    waits = ("waits for the database", "messages to and from the robots")
    until(lambda: sum(caplog.text.count(one) for one in waits) > 2 * STEP_ATTEMPTS)
    disk.why = ""
    assert follow(f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
    assert api.get(f"/v1/goals/{goal}").json()["outcome"] == "completed"
