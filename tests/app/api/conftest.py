"""A service that the tests of a module share, for modules whose tests change nothing in it.

Such a module must not use `service` as well: there can be only one in a process at a time.
"""

from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.world import load_world
from tests.app.conftest import TOKEN
from tests.app.declared import declared_errors
from tests.app.fake_robots import FakeTeam


@pytest.fixture(scope="module")
def shared_service(tmp_path_factory: pytest.TempPathFactory, worker: PlanningWorker) -> Iterator[Service]:
    settings = Settings(data=tmp_path_factory.mktemp("shared"), token=TOKEN, database_url=None)
    with FakeTeam() as team:
        file = load_world("sample_store")
        world = RunningWorld(file=file, link=team.link, clock=team.clock, rate=None, run=team.run)
        with Service(settings, [world], worker=worker) as service:
            yield service


@pytest.fixture
def shared_api(shared_service: Service) -> Iterator[TestClient]:
    with TestClient(shared_service.api, headers={"authorization": f"Bearer {TOKEN}"}) as client:
        client.event_hooks = {"response": [declared_errors(shared_service.api)]}
        yield client
