"""A fleet comes and goes by itself: its world goes on with the run that the record knows, and else starts a new run."""

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from app.composition import RunningWorld, Service
from app.missions.fleet_run import FleetRun
from app.planning.pool.pool import PlanningWorker
from app.planning.waiting_goals import WaitingGoals
from app.settings import Settings
from app.store import WorldRow
from robots.link.mqtt import Broker, FleetLink, ServiceLink
from robots.wire import Message, Performative, Telemetry
from robots.world import WorldFile
from tests.app.conftest import TOKEN
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.waiting import until

pytestmark = needs_mosquitto


@pytest.fixture(scope="module")
def shared_broker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path_factory.mktemp("broker")) as broker:
        yield broker


@pytest.fixture
def broker(shared_broker: Mosquitto) -> Mosquitto:
    """Keeps no announcement of the fleet of the test before."""
    retain(shared_broker, "")
    return shared_broker


@pytest.fixture
def link(broker: Mosquitto, world_file: WorldFile) -> Iterator[ServiceLink]:
    link = ServiceLink(world_file.name, [r.name for r in world_file.robots], Broker.at(broker.url))
    yield link
    link.close()


@pytest.fixture
def service(
    tmp_path: Path, world_file: WorldFile, worker: PlanningWorker, link: ServiceLink
) -> Iterator[Service]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None, answer_patience_s=0.6)
    world = RunningWorld(file=world_file, link=link, clock=link.clock, run=None, fleet=link)
    with Service(settings, [world], worker=worker) as service:
        yield service


@pytest.fixture
def fleet(broker: Mosquitto, world_file: WorldFile) -> Iterator[Callable[..., FleetLink]]:
    """Starts a fleet that drives a run, and ends the one before."""
    running: list[FleetLink] = []

    def start(run: str, packs: Mapping[str, str] | None = None) -> FleetLink:
        for link in running:
            link.close()
        robots = [robot.name for robot in world_file.robots]
        link = FleetLink(world_file.name, robots, Broker.at(broker.url), run=run, packs=packs)
        running.append(link)
        link.start()
        return link

    yield start
    for link in running:
        link.close()


def recorded_run(service: Service) -> str | None:
    with service.database.read() as session:
        return session.get_one(WorldRow, "sample_store").run


def connections(api: TestClient) -> set[str]:
    return {robot["connection"] for robot in api.get("/v1/robots").json()["items"]}


def samples(api: TestClient) -> dict[str, str]:
    facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
    return {fact["args"][0]: fact["args"][1] for fact in facts if fact["predicate"] == "in"}


def correct(api: TestClient) -> None:
    """Something becomes known that the world file does not say."""
    body = {"facts": [{"predicate": "in", "args": ["sample_1", "bay_12"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=body).status_code == 200
    assert samples(api)["sample_1"] == "bay_12"


def test_goals_are_planned_before_the_fleet_is_there_and_its_first_run_is_taken_up(
    service: Service,
    api: TestClient,
    follow: Callable[..., dict[str, Any]],
    fleet: Callable[[str], FleetLink],
) -> None:
    assert connections(api) == {"offline"}
    assert api.get("/readyz").status_code == 200
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
    assert follow(f"/v1/goals/{goal['id']}", "planned", "unsolvable")["state"] == "planned"
    fleet("run-1")
    until(lambda: recorded_run(service) == "run-1")
    until(lambda: connections(api) == {"online"})
    assert api.get(f"/v1/goals/{goal['id']}").json()["state"] == "planned"


class Announced:
    """A fleet's end of which only its run is known."""

    run: str | None = "run-9"
    taken_up: str | None = None

    def take_up(self, run: str) -> None:
        self.taken_up = run


def test_a_process_that_does_not_drive_the_world_takes_up_a_run_once_the_one_that_does_has_recorded_it(
    service: Service, world_file: WorldFile
) -> None:
    fleet = Announced()
    run = FleetRun(
        service.core,
        {world_file.name: world_file},
        world_file.name,
        fleet,
        waiting=WaitingGoals(service.core, clocks=service.clocks),
        holds_lease=lambda: False,
    )
    run.follow()
    assert fleet.taken_up is None
    with service.database.write() as session:
        session.get_one(WorldRow, world_file.name).run = "run-9"
    run.follow()
    assert fleet.taken_up == "run-9"


def test_a_fleet_that_comes_back_with_the_run_that_is_known_finds_the_facts_as_they_were(
    service: Service, api: TestClient, fleet: Callable[[str], FleetLink], link: ServiceLink
) -> None:
    fleet("run-2")
    until(lambda: link.taken_up == recorded_run(service) == "run-2")
    correct(api)
    fleet("run-2")
    until(lambda: connections(api) == {"online"})
    assert samples(api)["sample_1"] == "bay_12"


def test_with_another_run_the_world_starts_a_new_run_and_its_missions_have_failed(
    service: Service,
    api: TestClient,
    follow: Callable[..., dict[str, Any]],
    fleet: Callable[[str], FleetLink],
    link: ServiceLink,
) -> None:
    first = fleet("run-3")
    until(lambda: link.taken_up == "run-3")
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    committed = follow(f"/v1/goals/{goal['id']}", "committed")
    mission = f"/v1/missions/{committed['mission_id']}"
    follow(mission, "dispatching")
    orders: list[Message] = []
    until(lambda: orders.extend(first.receive(0.05)) or orders)
    correct(api)

    second = fleet("run-4")
    until(lambda: recorded_run(service) == "run-4")
    ended = follow(mission, "failed")
    assert ended["failure"] == "world_changed"
    assert "started again" in ended["reason"]
    assert samples(api)["sample_1"] == "door_1"
    until(lambda: link.taken_up == "run-4")
    assert [m for m in second.receive(0.5) if m.body.kind == "script_request"] == []


def test_robots_get_their_scripts_when_they_return_hours_later_though_the_broker_has_lost_all_it_kept(
    service: Service,
    broker: Mosquitto,
    api: TestClient,
    follow: Callable[..., dict[str, Any]],
    fleet: Callable[[str], FleetLink],
    link: ServiceLink,
) -> None:
    before = fleet("run-7")
    until(lambda: link.taken_up == "run-7")
    before.close()
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    committed = follow(f"/v1/goals/{goal['id']}", "committed")
    scripts = f"/v1/missions/{committed['mission_id']}/scripts"
    until(lambda: len(api.get(scripts).json()["items"]) == 2)
    time.sleep(2.0)  # they are sent again and again meanwhile, to nobody
    broker.kill()
    time.sleep(1.0)
    broker.start()

    returned = fleet("run-7")
    until(lambda: returned.connected)
    until(lambda: returned.announce(3 * 3600.0, 1.0) or service.clocks["sample_store"].now_s() >= 3 * 3600)
    orders: list[Message] = []
    until(lambda: orders.extend(returned.receive(0.05)) or len({m.receiver for m in orders}) == 2)
    assert {m.body.kind for m in orders} <= {"script_request", "status_query"}
    assert len(orders) <= 4, "the newest sending of each, not all that were sent in between"


def test_robots_of_a_fleet_that_breaks_down_are_shown_as_broken_until_they_come_again(
    api: TestClient, service: Service, fleet: Callable[[str], FleetLink]
) -> None:
    link = fleet("run-5")
    until(lambda: connections(api) == {"online"})
    for session in link._robots.values():
        session.retired = True
        sock = session.client.socket()
        assert sock is not None
        sock.shutdown(2)
    until(lambda: connections(api) == {"connection_broken"})
    fleet("run-5")
    until(lambda: connections(api) == {"online"})


def test_telemetry_reaches_the_board_and_the_clock_follows_the_fleet(
    api: TestClient, service: Service, fleet: Callable[[str], FleetLink], link: ServiceLink
) -> None:
    there = fleet("run-6")
    until(lambda: link.taken_up == "run-6" and there.connected)
    said = Telemetry(at_s=70.0, x_m=1.5, y_m=2.5, heading_rad=0.5, battery=0.75)
    there.send(
        Message(
            performative=Performative.INFORM, sender="yard_1", receiver="service", sent_at_s=70, body=said
        )
    )
    until(lambda: api.get("/v1/robots/yard_1").json()["battery"] == 0.75)
    until(lambda: there.announce(500.0, 1.0) or service.clocks["sample_store"].now_s() >= 500.0)


def test_a_fleet_with_other_domain_packs_is_named_until_it_has_the_same(
    service: Service, api: TestClient, fleet: Callable[..., FleetLink]
) -> None:
    ours = service.packs.digests()
    fleet("run-1", {**ours, "looks": "0123456789abcdef"})
    until(lambda: api.get("/readyz").status_code == 503)
    told = api.get("/readyz").json()
    assert told["type"] == "urn:macta:problem:packs-differ"
    assert "the fleet of sample_store: pack looks is not here" in told["detail"]
    fleet("run-2", ours)
    until(lambda: api.get("/readyz").status_code == 200)


@contextmanager
def served_beside(
    data: Path, world_file: WorldFile, worker: PlanningWorker, broker: Mosquitto
) -> Iterator[tuple[TestClient, ServiceLink]]:
    """A service that knows the digest of its world file."""
    names = [robot.name for robot in world_file.robots]
    link = ServiceLink(world_file.name, names, Broker.at(broker.url), digest="mine")
    world = RunningWorld(file=world_file, link=link, clock=link.clock, run=None, fleet=link)
    settings = Settings(data=data, token=TOKEN, database_url=None)
    with (
        Service(settings, [world], worker=worker) as service,
        TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api,
    ):
        yield api, link
    link.close()


def announce(broker: Mosquitto, **fields: Any) -> None:
    """As a stranger's fleet would."""
    retain(broker, json.dumps({"state": "online", "run": "of-a-stranger", "time_s": 7.0, **fields}))


def retain(broker: Mosquitto, announcement: str) -> None:
    """Have the broker keep it as the world's last announcement; none if it is empty."""
    client = Client(CallbackAPIVersion.VERSION2)
    client.connect("127.0.0.1", broker.port)
    client.loop_start()
    client.publish("macta/v1/sample_store/world", announcement, 1, retain=True).wait_for_publish(10)
    client.disconnect()
    client.loop_stop()


@pytest.mark.parametrize(
    ("said", "code", "words"),
    [
        ({"digest": "another"}, "world-differs", "another world file"),
        ({"contract": "2.0"}, "contract-differs", "another major version"),
    ],
)
def test_a_service_that_can_never_send_is_not_ready_and_says_why(
    tmp_path: Path,
    world_file: WorldFile,
    worker: PlanningWorker,
    broker: Mosquitto,
    said: dict[str, str],
    code: str,
    words: str,
) -> None:
    with served_beside(tmp_path, world_file, worker, broker) as (api, link):
        announce(broker, **said)
        until(lambda: link.fault is not None)
        refused = api.get("/readyz")
        assert (refused.status_code, refused.json()["type"]) == (503, f"urn:macta:problem:{code}")
        assert words in refused.json()["detail"]
        assert refused.json()["worlds"] == ["sample_store"]
        assert words in api.get("/v1/worlds/sample_store").json()["status_detail"]
        announce(broker, state="offline", **said)
        until(lambda: api.get("/readyz").status_code == 200)
        assert link.run is None


def test_a_world_whose_fleet_takes_up_another_world_file_waits_for_the_right_one(
    tmp_path: Path, world_file: WorldFile, worker: PlanningWorker, broker: Mosquitto
) -> None:
    with served_beside(tmp_path, world_file, worker, broker) as (api, link):

        def status() -> str:
            return str(api.get("/v1/worlds/sample_store").json()["status"])

        announce(broker)
        until(lambda: status() == "running")
        announce(broker, digest="another")
        until(lambda: link.fault is not None)
        assert status() == "waiting_for_fleet"
        announce(broker)
        until(lambda: status() == "running")


def test_a_fleet_that_says_nothing_of_its_world_file_is_accepted(
    tmp_path: Path, world_file: WorldFile, worker: PlanningWorker, broker: Mosquitto
) -> None:
    with served_beside(tmp_path, world_file, worker, broker) as (api, link):
        announce(broker, contract="1.7", purpose="a field that this version does not know")
        until(lambda: link.taken_up == "of-a-stranger")
        assert api.get("/readyz").status_code == 200


def test_what_is_wrong_with_a_message_that_was_dropped_is_shown(
    tmp_path: Path, world_file: WorldFile, worker: PlanningWorker, broker: Mosquitto
) -> None:
    with served_beside(tmp_path, world_file, worker, broker) as (api, link):
        announce(broker, run=3)
        until(lambda: link.malformed == 1)
        assert api.get("/readyz").json()["invalid_messages"] == {
            "sample_store": {
                "count": 1,
                "topic": "macta/v1/sample_store/world",
                "reason": "run: Input should be a valid string",
            }
        }
