"""The database server is killed with a mission under way: everything waits, comes back by itself and goes on."""

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
from sqlalchemy import func, select, update

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import Database, ExecutorRow
from app.store.migrate import migrate
from app.workflows.leases import ExecutorRegistry
from robots.world import WorldFile
from tests.app.conftest import PATIENCE_S, TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.serving import served
from tests.app.undone import Noted
from tests.cluster import Cluster, own_cluster
from tests.waiting import awaited, until

GIVE_UP_S = 180.0
"""DBOS tries again ever later, up to a minute apart."""
HEADERS = {"authorization": f"Bearer {TOKEN}"}


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    with own_cluster() as cluster:
        yield cluster


@pytest.fixture
def address(
    cluster: Cluster, tmp_path: Path, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> Iterator[str]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=cluster.url, answer_patience_s=PATIENCE_S)
    world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=worker) as service, served(service.api) as address:
        yield address


class Follower(threading.Thread):
    """A client on one open event stream."""

    def __init__(self, address: str) -> None:
        super().__init__(daemon=True)
        self.seen: list[dict[str, Any]] = []
        self.ended = ""
        self._address = f"{address}/v1/events?after=0"

    def run(self) -> None:
        try:
            with httpx2.stream("GET", self._address, headers=HEADERS, timeout=120) as answer:
                for line in answer.iter_lines():
                    if line.startswith("data:"):
                        self.seen.append(json.loads(line[5:]))
        except httpx2.HTTPError as error:
            self.ended = repr(error)


def test_a_mission_goes_on_after_the_server_was_killed_and_came_back(
    cluster: Cluster, address: str, team: FakeTeam, caplog: pytest.LogCaptureFixture
) -> None:
    follower = Follower(address)
    follower.start()
    team.faults.stuck.add("store_2")
    goal = {"text": "move sample_1 to bay_7", "auto_approve": True}
    with httpx2.Client(base_url=address, headers=HEADERS, timeout=60) as api:
        assert api.post("/v1/goals", json=goal).status_code == 202

        def mission() -> dict[str, Any]:
            items = api.get("/v1/missions").json()["items"]
            return items[0] if items else {"state": ""}  # type: ignore[no-any-return]

        until(lambda: mission()["state"] == "running")
        cluster.kill()
        for path in ("/v1/missions", "/v1/events"):
            refused = api.get(path)
            assert (refused.status_code, refused.json()["title"]) == (503, "Database away")
            assert int(refused.headers["retry-after"]) > 0
        team.faults.stuck.clear()  # robots finish meanwhile, and keep their reports
        until(lambda: caplog.text.count("heartbeat failed: database unavailable") > 2)
        until(lambda: "messages to and from the robots of sample_store wait" in caplog.text)
        cluster.start()
        until(lambda: api.get("/v1/missions").status_code == 200)
        awaited(mission, lambda last: last["state"] == "completed", GIVE_UP_S)
        until(lambda: "goal.finished" in [event["type"] for event in follower.seen])
    assert not follower.ended
    numbers = [event["seq"] for event in follower.seen]
    assert numbers == sorted(set(numbers))


def test_a_process_without_heartbeats_while_the_server_was_down_is_not_taken_for_dead(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.workflows.leases.DEAD_AFTER_S", 2.0)
    database = Database(cluster.url)
    migrate(database)
    recovered: list[tuple[str, str]] = []
    first, second = (
        ExecutorRegistry(database, Noted(name, recovered), serves=[], worlds=())
        for name in ("first", "second")
    )
    first.register()
    with database.write() as session:
        session.execute(update(ExecutorRow).values(seen_at=ExecutorRow.seen_at - 60.0))
    cluster.kill()
    cluster.start()
    second.register()
    second.start()
    until(lambda: recovered)  # by now the first could have written a heartbeat
    with database.read() as session:
        up = session.scalars(select(func.clock_timestamp() - func.pg_postmaster_start_time())).one()
    second.close()
    database.close()
    assert recovered[0] == ("second", "first")
    assert up.total_seconds() >= 2.0
