"""Of what there may be only so many, one more is told when to come again; nothing grows without end."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from threading import Thread

import httpx2
import pytest
from fastapi.testclient import TestClient

from app.agents.questions import MAX_OPEN, Questions
from app.composition import RunningWorld, Service
from app.domain.clock import SYSTEM_CLOCK
from app.domain.errors import Busy, Silent
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.workflows.retention import DAY_S, Retention
from robots.world import WorldFile
from tests.app.api.test_events import post, stream, until
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.serving import served
from tests.app.stepped_clock import SteppedClock

GOALS, STREAMS = 3, 2
HEADERS = {"authorization": f"Bearer {TOKEN}"}


@pytest.fixture
def service(
    tmp_path: Path, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> Iterator[Service]:
    settings = Settings(
        data=tmp_path,
        token=TOKEN,
        database_url=None,
        open_goals=GOALS,
        open_streams=STREAMS,
        keep_events=1000,
    )
    world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=worker) as service:
        yield service


@pytest.fixture
def address(service: Service) -> Iterator[str]:
    with served(service.api) as address:
        yield address


def test_of_goals_only_so_many_may_be_open_and_one_that_is_cancelled_makes_room(api: TestClient) -> None:
    goals = [api.post("/v1/goals", json={"text": f"move sample_1 to bay_{7 + n}"}) for n in range(GOALS)]
    assert {answer.status_code for answer in goals} == {202}
    refused = api.post("/v1/goals", json={"text": "move sample_4 to door_2"})
    assert (refused.status_code, refused.json()["type"]) == (429, "urn:macta:problem:too-many-goals")
    assert int(refused.headers["retry-after"]) > 0
    assert "MACTA_OPEN_GOALS" in refused.json()["detail"]
    assert len(api.get("/v1/goals").json()["items"]) == GOALS
    api.post(f"/v1/goals/{goals[0].json()['id']}:cancel")
    assert api.post("/v1/goals", json={"text": "move sample_4 to door_2"}).status_code == 202


def test_of_streams_only_so_many_may_be_open(address: str) -> None:
    with ExitStack() as streams:
        telemetry = "/v1/telemetry?world=sample_store"
        # NOTE: all are kept, for a stream that nobody holds any longer is closed.
        opened = [streams.enter_context(stream(address, telemetry)) for _ in range(STREAMS)]
        for events in opened:
            next(events)
        for path in ("/v1/events", telemetry):
            refused = httpx2.get(address + path, headers=HEADERS)
            assert (refused.status_code, refused.json()["type"]) == (
                429,
                "urn:macta:problem:too-many-streams",
            )
            assert "retry-after" in refused.headers


def test_a_client_that_resumes_after_what_is_forgotten_receives_a_reset_and_the_current_state(
    address: str, service: Service
) -> None:
    goal = post(address, "move sample_1 to bay_7")
    with stream(address, "/v1/events", **{"last-event-id": "0"}) as events:
        until(events, "plan.proposed")
    Retention(service.database, service.core.workflows, days=30, goals_days=365, events=1).sweep()
    with stream(address, "/v1/events", **{"last-event-id": "1"}) as events:
        first, second = next(events), next(events)
    assert (first["type"], first["data"]) == ("stream.reset", {"seen": 1})
    assert (second["type"], second["subject"]) == ("goal.state", goal["id"])


def test_of_a_goal_that_is_deleted_is_said_that_it_may_have_been(api: TestClient, service: Service) -> None:
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()["id"]
    api.post(f"/v1/goals/{goal}:cancel")
    later = Retention(
        service.database,
        service.core.workflows,
        days=30,
        goals_days=1,
        events=1000,
        clock=SteppedClock(SYSTEM_CLOCK.epoch_s() + 2 * DAY_S),
    )
    assert later.sweep().goals == 1
    gone = api.get(f"/v1/goals/{goal}")
    assert (gone.status_code, gone.json()["type"]) == (404, "urn:macta:problem:unknown-goal")
    assert "MACTA_KEEP_GOALS_DAYS" in gone.json()["detail"]
    assert api.get("/v1/goals").json()["items"] == []


def test_of_questions_to_a_robot_only_so_many_may_be_open() -> None:
    questions, silent = Questions(patience_s=5.0), []

    def ask() -> None:
        try:
            questions.trace("fred", 1.0)
        except Silent as error:
            silent.append(error)

    waiting = [Thread(target=ask) for _ in range(MAX_OPEN)]
    for thread in waiting:
        thread.start()
    sent: list[str] = []
    while len(sent) < MAX_OPEN:
        sent += [one.id for one in questions.to_send({"fred"})]
    with pytest.raises(Busy, match="8 questions to fred are open"):
        questions.trace("fred", 1.0)
    for thread in waiting:
        thread.join()
    assert len(silent) == MAX_OPEN
