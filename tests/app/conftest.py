"""A whole service on a fake team of robots: real database, workflows, planner and API."""

import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import Engine, event

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import Database
from app.store.migrate import migrate
from app.workflows import Workflows
from robots.world import WorldFile, load_world
from tests.app.declared import declared_errors
from tests.app.fake_robots import FakeTeam
from tests.databases import SQLITE
from tests.waiting import in_state, until

TOKEN = "a-token-for-the-tests"
PATIENCE_S = 0.6


@pytest.fixture(scope="session")
def migrated_record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An SQLite file with all tables and no goals, to be copied: most tests are not about migrations."""
    file = tmp_path_factory.mktemp("record") / "macta.sqlite"
    database = Database(f"sqlite:///{file}")
    migrate(database)
    workflows = Workflows(f"sqlite:///{file}")
    workflows.launch()  # makes the tables of DBOS
    workflows.close()
    with database.engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
    database.close()
    return file


@pytest.fixture
def database_url(database_url: str, migrated_record: Path) -> str:
    """An empty record; on SQLite it has its tables."""
    if database_url.startswith(SQLITE):
        shutil.copyfile(migrated_record, database_url.removeprefix("sqlite:///"))
    return database_url


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    """An empty record with its tables."""
    database = Database(database_url)
    migrate(database)
    yield database
    database.close()


@pytest.fixture
def team() -> Iterator[FakeTeam]:
    with FakeTeam() as team:
        yield team


@pytest.fixture
def world_file() -> WorldFile:
    return load_world("sample_store")


def connections_lent(engine: Engine) -> set[object]:
    """The connections that are in use, from now on. The pool itself counts wrong once the engine is disposed of."""
    lent: set[object] = set()
    event.listen(engine, "checkout", lambda _, record, __: lent.add(record))
    event.listen(engine, "checkin", lambda _, record: lent.discard(record))
    return lent


@pytest.fixture
def service(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> Iterator[Service]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url, answer_patience_s=PATIENCE_S)
    world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=worker) as service:
        lent = connections_lent(service.database.engine)
        yield service
    # A step that was under way may still give one back; one that is never given back is a leak.
    until(lambda: not lent, "connections of the record are never given back")


@pytest.fixture
def api(service: Service) -> Iterator[TestClient]:
    with TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as client:
        client.event_hooks = {"response": [declared_errors(service.api)]}
        yield client


@pytest.fixture
def follow(api: TestClient) -> Callable[[str, str], dict]:  # type: ignore[type-arg]
    """`follow("/v1/goals/ID", "planned")` reads a thing until it is in one of the states, and answers it."""

    return partial(in_state, api)
