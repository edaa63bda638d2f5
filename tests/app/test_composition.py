"""The service as a whole: how it begins and ends."""

import re
from concurrent.futures import Future
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings, lock_folder
from app.workflows.leases import ExecutorRegistry
from robots.world import load_world
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedWorker
from tests.app.undone import Noted
from tests.waiting import in_state


def test_a_start_that_is_interrupted_leaves_nothing_open(
    tmp_path: Path, team: FakeTeam, worker: PlanningWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None)
    world = RunningWorld(
        file=load_world("sample_store"), link=team.link, clock=team.clock, rate=None, run=team.run
    )
    service = Service(settings, [world], worker=worker)

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(service.core.workflows, "launch", interrupted)
    with pytest.raises(KeyboardInterrupt), service:
        pass
    lock_folder(tmp_path).close()


class SlowWorker(ScriptedWorker):
    """Is warm once the test says so."""

    def __init__(self, store: Store) -> None:
        super().__init__(store.store_sample_1())
        self.ready: Future[bool] = Future()
        self.doing = "compiling the planner"

    def warm_up(self) -> Future[bool]:
        return self.ready


def test_missions_are_paused_and_cancelled_while_the_planner_warms_up(tmp_path: Path, team: FakeTeam) -> None:
    store = Store()
    team.faults.stuck.add("yard_1")
    worker = SlowWorker(store)
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None)
    world = RunningWorld(file=store.world, link=team.link, clock=team.clock, rate=None, run=team.run)
    with (
        Service(settings, [world], worker=worker) as service,
        TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api,
    ):
        assert api.get("/healthz").status_code == 200
        starting = api.get("/readyz")
        assert (starting.status_code, starting.json()["type"]) == (503, "urn:macta:problem:starting")
        assert "compiling the planner" in starting.json()["detail"]
        goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
        committed = in_state(api, f"/v1/goals/{goal['id']}", "committed")
        mission = f"/v1/missions/{committed['mission_id']}"
        assert api.post(f"{mission}:pause").status_code == 202
        assert api.post(f"{mission}:cancel").status_code == 202
        assert not service.planner_ready.done()
        worker.ready.set_result(True)
        assert api.get("/readyz").json() == {"status": "ready", "compilation": "compiled"}


def test_a_process_with_other_domain_packs_is_named(service: Service, api: TestClient) -> None:
    (own,) = api.get("/v1/executors").json()["items"]
    assert own["packs"] == {pack.name: pack.digest() for pack in service.packs.packs}
    assert api.get("/readyz").status_code == 200
    other = ExecutorRegistry(
        service.database, Noted("other"), serves=["planning"], worlds=(), packs={"store": "0123456789abcdef"}
    )
    other.register()
    answer = api.get("/readyz")
    assert (answer.status_code, answer.json()["type"]) == (503, "urn:macta:problem:packs-differ")
    assert re.search(r"same packs.*executor other on .*: pack store is another", answer.json()["detail"])
