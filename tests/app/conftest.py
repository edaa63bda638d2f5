"""A whole service on a fake team of robots: real database, workflows, planner and API."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service, make_engine
from app.plans.worker import PlanningWorker
from app.settings import Settings
from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeTeam

TOKEN = "a-token-for-the-tests"
PATIENCE_S = 0.6
DEADLINE_S = 30.0


@pytest.fixture(scope="session")
def worker() -> Iterator[PlanningWorker]:
    worker = PlanningWorker(make_engine)
    worker.warm_up().result(timeout=300)
    yield worker
    worker.close()


@pytest.fixture
def team() -> Iterator[FakeTeam]:
    with FakeTeam() as team:
        yield team


@pytest.fixture
def world_file() -> WorldFile:
    return load_world("sample_store")


@pytest.fixture
def service(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> Iterator[Service]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url, answer_patience_s=PATIENCE_S)
    world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=worker) as service:
        yield service


@pytest.fixture
def api(service: Service) -> Iterator[TestClient]:
    with TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as client:
        yield client


@pytest.fixture
def follow(api: TestClient) -> Callable[[str, str], dict]:  # type: ignore[type-arg]
    """`follow("/v1/goals/ID", "planned")` reads a thing until it is in one of the states, and answers it."""

    def until(path: str, *states: str) -> dict:  # type: ignore[type-arg]
        give_up = time.monotonic() + DEADLINE_S
        while (thing := api.get(path).json())["state"] not in states:
            assert time.monotonic() < give_up, f"{path} stays {thing['state']}: {thing.get('reason')}"
            time.sleep(0.02)
        return thing

    return until
