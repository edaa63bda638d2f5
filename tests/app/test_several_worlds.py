"""One service for several worlds, each with a fleet of its own behind the broker."""

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.cli.long_running import enter_all, world_over_broker
from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import Database
from app.store.migrate import migrate
from app.workflows.leases import ExecutorRegistry
from robots.link.mqtt import Broker, FleetLink
from robots.world import WorldFile, digest_of, load_world
from tests.app.conftest import TOKEN
from tests.app.undone import Noted
from tests.databases import ON_POSTGRESQL
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.waiting import until

pytestmark = needs_mosquitto
HEADERS = {"authorization": f"Bearer {TOKEN}"}
GOALS = {"sample_store": "move sample_1 to bay_7", "relocation_lab": "move rock_sample to lander"}


@pytest.fixture(scope="module")
def broker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Broker]:
    with mosquitto(tmp_path_factory.mktemp("broker")) as broker:
        yield Broker.at(broker.url)


@pytest.fixture
def worlds(broker: Broker) -> Iterator[list[RunningWorld]]:
    with enter_all(world_over_broker(broker, load_world(name)) for name in GOALS) as worlds:
        yield list(worlds)


def fleet_of(world: WorldFile, broker: Broker) -> FleetLink:
    names = [robot.name for robot in world.robots]
    return FleetLink(world.name, names, broker, run=f"of {world.name}", digest=digest_of(world))


def robots_with_orders(fleet: FleetLink) -> set[str]:
    return {message.receiver for message in fleet.receive(0.02) if message.body.kind == "script_request"}


def test_each_fleet_gets_the_scripts_of_its_own_world(
    tmp_path: Path, broker: Broker, worlds: list[RunningWorld], worker: PlanningWorker
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None, answer_patience_s=0.6)
    with ExitStack() as ends:
        service = ends.enter_context(Service(settings, worlds, worker=worker))
        api = ends.enter_context(TestClient(service.api, headers=HEADERS))
        told: dict[str, set[str]] = {}
        fleets = {
            world.file.name: ends.enter_context(closing(fleet_of(world.file, broker))) for world in worlds
        }
        for fleet in fleets.values():
            fleet.start()
        for name, text in GOALS.items():
            wish = {"world": name, "text": text, "auto_approve": True}
            assert api.post("/v1/goals", json=wish).status_code == 202

        def all_have_orders() -> bool:
            for name, fleet in fleets.items():
                told.setdefault(name, set()).update(robots_with_orders(fleet))
            return all(told.values())

        until(all_have_orders, told)
    for world in worlds:
        assert told[world.file.name] <= {robot.name for robot in world.file.robots}


def test_worlds_are_listed_in_the_order_they_were_asked_for(
    tmp_path: Path, worlds: list[RunningWorld], worker: PlanningWorker
) -> None:
    assert sorted(GOALS) != list(GOALS)
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None, answer_patience_s=0.6)
    with Service(settings, worlds, worker=worker) as service, TestClient(service.api, headers=HEADERS) as api:
        assert [world["id"] for world in api.get("/v1/worlds").json()["items"]] == list(GOALS)


@ON_POSTGRESQL
def test_a_world_is_known_though_the_process_that_speaks_for_it_has_said_nothing_of_it(
    tmp_path: Path, database_url: str, worlds: list[RunningWorld], worker: PlanningWorker
) -> None:
    database = Database(database_url)
    migrate(database)
    names: list[str] = [world.file.name for world in worlds]
    ExecutorRegistry(database, Noted("another"), serves=[], worlds=names).register()
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url)
    with Service(settings, worlds, worker=worker) as service:
        assert not any(service.executors.holds_lease(name) for name in names)
        assert sorted(one.id for one in service.worlds.reports()) == sorted(names)
    database.close()
