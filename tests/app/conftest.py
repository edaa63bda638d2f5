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
from tests.databases import POSTGRESQL, SQLITE, postgresql
from tests.waiting import LONG_S, in_state, until

TOKEN = "a-token-for-the-tests"
PATIENCE_S = 0.6


def make_tables(url: str) -> None:
    """All tables, and no goals: made once and copied, for most tests are not about migrations."""
    database = Database(url)
    migrate(database)
    workflows = Workflows(url)
    workflows.launch()  # makes the tables of DBOS
    workflows.close()
    if url.startswith(SQLITE):
        with database.engine.connect() as connection:
            connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
    database.close()


@pytest.fixture(scope="session")
def empty_record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An SQLite file to be copied."""
    file = tmp_path_factory.mktemp("record") / "macta.sqlite"
    make_tables(f"sqlite:///{file}")
    return file


@pytest.fixture(scope="session")
def empty_template() -> Iterator[str]:
    """The name of a database on PostgreSQL to be copied."""
    with postgresql() as url:
        make_tables(url)
        yield url.rpartition("/")[2]


@pytest.fixture
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty record with its tables: SQLite, or what `ON_BOTH` and `ON_POSTGRESQL` of `tests.databases` ask for."""
    if getattr(request, "param", SQLITE) == POSTGRESQL:
        with postgresql(request.getfixturevalue("empty_template")) as url:
            yield url
    else:
        file = shutil.copyfile(request.getfixturevalue("empty_record"), tmp_path / "macta.sqlite")
        yield f"sqlite:///{file}"


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
def patient(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    """Robots may take as long to answer a question as a busy machine makes them."""
    monkeypatch.setattr(service.questions, "_patience_s", LONG_S)


@pytest.fixture
def api(service: Service) -> Iterator[TestClient]:
    with TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as client:
        client.event_hooks = {"response": [declared_errors(service.api)]}
        yield client


@pytest.fixture
def follow(api: TestClient) -> Callable[[str, str], dict]:  # type: ignore[type-arg]
    """`follow("/v1/goals/ID", "planned")` reads a thing until it is in one of the states, and answers it."""

    return partial(in_state, api)
