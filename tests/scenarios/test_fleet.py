"""Production: the service, the fleet that drives the world, and the broker between them."""

import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.planning.pool.pool import PlanningWorker
from robots.link.mqtt import Broker, FleetLink
from robots.world import digest_of, load_world
from sim.process.snapshot_file import SnapshotFile, SnapshotSettings
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.judge import snapshot_truth
from tests.scenarios.killing import kill_family, process_of_the_world
from tests.scenarios.services import AUTHORISED, over_broker
from tests.scenarios.serving import macta_fleet
from tests.waiting import awaited, in_state, mission_of

pytestmark = needs_mosquitto
WORLD = "sample_store"


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


@pytest.fixture
def api(tmp_path: Path, worker: PlanningWorker, broker: Mosquitto) -> Iterator[TestClient]:
    with (
        over_broker(tmp_path / "service", worker, broker.url) as service,
        TestClient(service.api, headers=AUTHORISED) as api,
    ):
        yield api


def connections(api: TestClient) -> set[str]:
    return {robot["connection"] for robot in api.get("/v1/robots").json()["items"]}


def started(api: TestClient, text: str) -> str:
    """The path of a mission that is under way."""
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).json()
    mission = f"/v1/missions/{mission_of(api, goal['id'])}"
    in_state(api, mission, "running")
    return mission


def ended(api: TestClient, mission: str) -> dict[str, Any]:
    return in_state(api, mission, "completed", "partially_completed", "failed", "cancelled")


def place_of(api: TestClient, sample: str) -> str:
    facts = api.get(f"/v1/worlds/{WORLD}/facts").json()["items"]
    (place,) = (f["args"][1] for f in facts if f["predicate"] == "in" and f["args"][0] == sample)
    return str(place)


def test_a_mission_outlives_broker_and_world_and_its_fleet_ends_in_order(
    api: TestClient, broker: Mosquitto, tmp_path: Path
) -> None:
    kept = tmp_path / "fleet"
    assert connections(api) == {"offline"}
    with macta_fleet(kept, "--broker", broker.url, "--speed", "10") as fleet:
        awaited(lambda: connections(api), {"online"}.__eq__)
        mission = started(api, "move sample_1 to bay_7")
        broker.kill()
        time.sleep(0.5)
        broker.start()
        kill_family(process_of_the_world(fleet.pid, kept))
        assert ended(api, mission)["state"] == "completed"
        assert place_of(api, "sample_1") == "bay_7"

        fleet.send_signal(signal.SIGTERM)
        assert fleet.wait(timeout=60) == 0
        awaited(lambda: connections(api), {"offline"}.__eq__)
        assert snapshot_truth(kept).samples["sample_1"].ref == "bay_7"


def test_a_fleet_follows_changes_of_its_world_and_keeps_them_when_it_starts_again(
    api: TestClient, broker: Mosquitto, tmp_path: Path
) -> None:
    kept = tmp_path / "fleet"
    changes = f"/v1/worlds/{WORLD}/changes"
    robot = {"name": "yard_3", "compartment": "yard", "start": [4, 1.4, -90]}
    edits = [
        {"edit": "add_sample", "sample": {"name": "sample_9", "at": "door_2"}},
        {"edit": "remove_robot", "name": "yard_2"},
        {"edit": "add_robot", "robot": robot},
    ]
    with macta_fleet(kept, "--broker", broker.url, "--speed", "10"):
        awaited(lambda: connections(api), {"online"}.__eq__)
        api.post(changes, json={"reason": "a test", "edits": edits}).raise_for_status()
        awaited(lambda: api.get(changes).json()["items"][0]["delivery"], "taken_up".__eq__)
        assert {one["id"] for one in api.get("/v1/robots").json()["items"]} == {
            "yard_1",
            "yard_3",
            "store_1",
            "store_2",
        }
        awaited(lambda: connections(api), {"online"}.__eq__)
    with macta_fleet(kept, "--broker", broker.url, "--speed", "10"):
        awaited(lambda: connections(api), {"online"}.__eq__)
        mission = started(api, "move sample_9 to bay_7 with yard_3 and store_2")
        assert ended(api, mission)["state"] == "completed"
        assert place_of(api, "sample_9") == "bay_7"


def keep_a_world(folder: Path) -> str:
    """A snapshot of the world at its start, as a fleet keeps it; its run."""
    world = load_world(WORLD)
    simulation = Simulation(world, make_agent=behavioural_agent, seed=1, jitter_m=0.0)
    with SnapshotFile(SnapshotSettings(folder=folder / "worlds").path_of(world)) as file:
        file.write(simulation.snapshot())
    simulation.close()
    return simulation.run


def correct(api: TestClient) -> None:
    """Something becomes known that the world file does not say."""
    body = {"facts": [{"predicate": "in", "args": ["sample_1", "bay_12"]}]}
    assert api.put(f"/v1/worlds/{WORLD}/facts", json=body).status_code == 200


def test_a_fleet_may_start_a_new_run_and_is_broken_when_it_was_killed(
    api: TestClient, broker: Mosquitto, tmp_path: Path
) -> None:
    kept, world = tmp_path / "fleet", load_world(WORLD)
    names = [robot.name for robot in world.robots]
    before = FleetLink(WORLD, names, Broker.at(broker.url), run=keep_a_world(kept), digest=digest_of(world))
    before.start()
    awaited(lambda: connections(api), {"online"}.__eq__)
    correct(api)
    before.close()
    awaited(lambda: connections(api), {"offline"}.__eq__)
    assert place_of(api, "sample_1") == "bay_12"

    with macta_fleet(kept, "--broker", broker.url, "--afresh") as fleet:
        awaited(lambda: place_of(api, "sample_1"), "door_1".__eq__)
        awaited(lambda: connections(api), {"online"}.__eq__)
        fleet.kill()
        awaited(lambda: connections(api), {"connection_broken"}.__eq__)
    assert api.get("/readyz").status_code == 200
