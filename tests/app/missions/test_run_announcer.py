"""A world without a robot to simulate is announced by the service, which gives way to a fleet that comes."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import WorldRow
from robots.link.mqtt import Broker, FleetLink, ServiceLink
from robots.world import WorldFile, digest_of
from tests.app.conftest import TOKEN
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.waiting import until

pytestmark = needs_mosquitto


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def foreign_world(world_file: WorldFile) -> WorldFile:
    """The store, with robots that all have software of their own."""
    return world_file.model_copy(
        update={"robots": tuple(one.model_copy(update={"external": True}) for one in world_file.robots)}
    )


class HasteClock:
    """The wall clock of a link, by which time passes twenty times as fast."""

    def __init__(self) -> None:
        self._began_s = time.monotonic()

    def __call__(self) -> float:
        return (time.monotonic() - self._began_s) * 20


@contextmanager
def served(
    data: Path, world: WorldFile, broker: Mosquitto, worker: PlanningWorker, *, start_new: bool = False
) -> Iterator[tuple[Service, ServiceLink]]:
    names = [robot.name for robot in world.robots]
    link = ServiceLink(world.name, names, Broker.at(broker.url), digest=digest_of(world), wall_s=HasteClock())
    settings = Settings(data=data, token=TOKEN, database_url=None)
    running = RunningWorld(file=world, link=link, clock=link.clock, run=None, fleet=link, start_new=start_new)
    with Service(settings, [running], worker=worker) as service:
        yield service, link
    link.close()


def recorded_run(service: Service) -> str | None:
    with service.database.read() as session:
        return session.get_one(WorldRow, "sample_store").run


def api_of(service: Service) -> TestClient:
    return TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"})


def test_the_run_and_time_of_a_world_without_a_fleet_go_on_over_restarts(
    tmp_path: Path, foreign_world: WorldFile, broker: Mosquitto, worker: PlanningWorker
) -> None:
    with served(tmp_path, foreign_world, broker, worker) as (service, link):
        until(lambda: link.taken_up is not None)
        run = link.taken_up
        assert recorded_run(service) == run
        assert link.announced_by == "service"
        until(lambda: link.clock.now_s() > 0)
        time_s = link.clock.now_s()
    broker.kill()  # and all that it retained is lost
    broker.start()
    with served(tmp_path, foreign_world, broker, worker) as (service, link):
        until(lambda: link.taken_up is not None)
        assert (link.taken_up, recorded_run(service)) == (run, run)
        assert link.clock.now_s() >= time_s / 20  # the haste is the link's alone
    with served(tmp_path, foreign_world, broker, worker, start_new=True) as (service, link):
        until(lambda: link.taken_up not in (None, run))
        until(lambda: recorded_run(service) == link.taken_up)


def test_the_service_does_not_announce_a_world_with_a_robot_to_simulate(
    tmp_path: Path, world_file: WorldFile, broker: Mosquitto, worker: PlanningWorker
) -> None:
    with served(tmp_path, world_file, broker, worker) as (service, link), api_of(service) as api:
        until(lambda: link.fleetless_s > 60)  # of its hasty clock
        assert link.run is None
        assert api.get("/readyz").json()["waiting_for_fleet"] == ["sample_store"]


def test_a_fleet_that_comes_is_given_way_to_and_numbered_after_those_before_it(
    tmp_path: Path, foreign_world: WorldFile, broker: Mosquitto, worker: PlanningWorker
) -> None:
    with served(tmp_path, foreign_world, broker, worker) as (service, link):
        until(lambda: link.taken_up is not None)
        fleet = FleetLink(
            "sample_store", (), Broker.at(broker.url), run="a-fleets", digest=digest_of(foreign_world)
        )
        fleet.start()
        try:
            # NOTE: by the link's hasty clock, a fleet that has announced once is soon gone.
            until(lambda: (fleet.announce(0.0, 1.0), link.taken_up == "a-fleets")[1])
            for time_s in range(100, 400):
                fleet.announce(float(time_s), 1.0)
            until(lambda: (fleet.announce(400.0, 1.0), link.clock.now_s() >= 400.0)[1])
            assert link.announced_by == "fleet"
            assert not fleet.superseded
        finally:
            fleet.close()
        until(lambda: link.announced_by == "service")
        assert recorded_run(service) == link.run == "a-fleets"
        assert link.clock.now_s() >= 400.0


def test_a_change_of_a_world_that_nobody_simulates_is_taken_up_at_once(
    tmp_path: Path, foreign_world: WorldFile, broker: Mosquitto, worker: PlanningWorker
) -> None:
    changes = "/v1/worlds/sample_store/changes"
    edits = [{"edit": "add_sample", "sample": {"name": "sample_9", "at": "door_2"}}]
    with (
        served(tmp_path, foreign_world, broker, worker) as (service, link),
        api_of(service) as api,
    ):
        until(lambda: link.taken_up is not None)
        api.post(changes, json={"reason": "a test", "edits": edits}).raise_for_status()
        until(lambda: api.get(changes).json()["items"][0]["delivery"] == "taken_up")
