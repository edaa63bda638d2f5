"""Worlds that fleets drive: added by one process, followed by the others, and waiting for their fleets."""

import itertools
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.agents.running_worlds import RunningWorlds
from app.cli.long_running import FleetHost, world_over_broker
from app.composition import Service
from app.core import Core
from app.missions.world_set import FileChecks, WorldSet
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import Database
from app.store.editions import WorldDirectory
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from planner import load_knowledge_base
from robots.link.mqtt import Broker, FleetLink
from robots.wire import Message
from robots.world import WorldFile, digest_of, world_yaml
from tests.app.conftest import TOKEN
from tests.app.missions.mission_services import NoWorkflows
from tests.app.world_hosts import hall
from tests.databases import ON_BOTH, ON_POSTGRESQL
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.waiting import in_state, read_until, until

pytestmark = needs_mosquitto


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    """One a test: it keeps what fleets have announced."""
    with mosquitto(tmp_path) as broker:
        yield Broker.at(broker.url)


@pytest.fixture
def api(
    tmp_path: Path, database_url: str, world_file: WorldFile, broker: Broker, worker: PlanningWorker
) -> Iterator[TestClient]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url)
    with (
        world_over_broker(broker, world_file) as world,
        Service(settings, [world], worker=worker, host=FleetHost(broker)) as service,
        TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as client,
    ):
        yield client


@pytest.fixture
def other(database_url: str, world_file: WorldFile, broker: Broker) -> Iterator[WorldSet]:
    """The worlds of another process on the database, which speaks for none of them."""
    database = Database(database_url)
    base = load_knowledge_base()
    events = EventLog(database)
    nets = PlanNets(base)
    core = Core(
        database=database,
        events=events,
        facts=FactStore(events, base),
        workflows=NoWorkflows(),  # type: ignore[arg-type]
        knowledge_base=base,
        plan_nets=nets,
        reservations=Reservations(nets),
    )

    def none(*_: object) -> Any:
        raise AssertionError("it speaks for no world")

    running = RunningWorlds([], agents=none, listen=none)
    yield WorldSet(
        core,
        files=WorldDirectory(database, {world_file.name: world_file}),
        running=running,
        host=FleetHost(broker),
        checks=FileChecks(tags=(), tuning=none, rules=none),
        limit=4,
    )
    running.end()
    database.close()


def fleet_of(world: WorldFile, broker: Broker) -> FleetLink:
    names = [robot.name for robot in world.robots]
    return FleetLink(world.name, names, broker, run=f"of {world.name}", digest=digest_of(world))


def orders(messages: list[Message]) -> set[str]:
    return {message.receiver for message in messages if message.body.kind == "script_request"}


@ON_BOTH
def test_an_added_world_waits_for_a_fleet_that_is_started_with_the_same_file(
    api: TestClient, broker: Broker
) -> None:
    yaml = {"content-type": "application/yaml"}
    added = api.post("/v1/worlds", content=world_yaml(hall("hall")), headers=yaml).json()
    assert added["status"] == "waiting_for_fleet"
    assert "macta fleet" in added["status_detail"]
    body = {"text": "move sample_1 to bay_7", "world": "hall", "auto_approve": True}
    goal = f"/v1/goals/{api.post('/v1/goals', json=body).json()['id']}"
    in_state(api, goal, "committed")
    with closing(fleet_of(hall("hall", title="another"), broker)) as wrong:
        wrong.start()
        until(lambda: wrong.connected)
        assert api.get("/v1/worlds/hall").json()["status"] == "waiting_for_fleet"
    with closing(fleet_of(hall("hall"), broker)) as fleet:
        fleet.start()
        told: set[str] = set()
        seconds = itertools.count()

        def has_orders() -> bool:
            fleet.announce(float(next(seconds)), 1.0)
            told.update(orders(list(fleet.receive(0.02))))
            return bool(told)

        until(has_orders)
        read_until(api, "/v1/worlds/hall", lambda world: world["status"] == "running")
    assert all(robot.startswith("hall_") for robot in told)


def test_the_rate_is_the_fleets(api: TestClient) -> None:
    refused = api.post("/v1/worlds?rate=2", json=hall("hall").model_dump(mode="json"))
    assert refused.status_code == 422
    assert refused.json()["type"] == "urn:macta:problem:rate-of-fleet"


@ON_POSTGRESQL
def test_what_another_process_adds_and_removes_is_followed(api: TestClient, other: WorldSet) -> None:
    other.add(hall("hall"), rate=None, actor="another", reason="")
    body = {"text": "move sample_1 to bay_7", "world": "hall"}  # at once
    stated = api.post("/v1/goals", json=body)
    assert stated.status_code == 202, stated.text
    goal = f"/v1/goals/{stated.json()['id']}"
    in_state(api, goal, "planned")
    until(lambda: any("hall" in one["worlds"] for one in api.get("/v1/executors").json()["items"]))
    api.post(f"{goal}:cancel", json={}).raise_for_status()
    other.remove("hall", actor="another", reason="")
    until(lambda: [one["id"] for one in api.get("/v1/worlds").json()["items"]] == ["sample_store"])
    until(lambda: not any("hall" in one["worlds"] for one in api.get("/v1/executors").json()["items"]))
    other.add(hall("hall", title="again"), rate=None, actor="another", reason="")
    # The list asks for none by its name, so it only has what was announced.
    until(lambda: [one["title"] for one in api.get("/v1/worlds").json()["items"]][1:] == ["again"])
