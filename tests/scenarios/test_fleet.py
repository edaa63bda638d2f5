"""Production: the service, the fleet that drives the world, and the broker between them, each a process of its own."""

import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.judge import snapshot_truth
from tests.scenarios.killing import kill_family, process_of_the_world
from tests.scenarios.serving import macta_fleet, macta_serve
from tests.waiting import awaited, in_state, read_until

pytestmark = [needs_mosquitto, pytest.mark.timeout(600)]
GIVE_UP_S = 200.0
SPEED = ("--speed", "4")


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


def connections(api: httpx2.Client) -> set[str]:
    return {robot["connection"] for robot in api.get("/v1/robots").json()["items"]}


def started(api: httpx2.Client, text: str) -> str:
    """The path of a mission that is under way."""
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).json()
    committed = read_until(api, f"/v1/goals/{goal['id']}", lambda g: g["mission_id"] is not None)
    mission = f"/v1/missions/{committed['mission_id']}"
    in_state(api, mission, "running")
    return mission


def ended(api: httpx2.Client, mission: str) -> dict[str, Any]:
    over = ("completed", "partially_completed", "failed", "cancelled")
    return in_state(api, mission, *over, within_s=GIVE_UP_S)


def place_of(api: httpx2.Client, sample: str) -> str:
    facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
    (place,) = (f["args"][1] for f in facts if f["predicate"] == "in" and f["args"][0] == sample)
    return str(place)


def test_a_mission_outlives_broker_and_world_its_fleet_ends_in_order_and_may_begin_afresh(
    tmp_path: Path, broker: Mosquitto
) -> None:
    kept = tmp_path / "fleet"
    with (
        macta_serve(tmp_path / "serve", broker_url=broker.url) as served,
        served.client() as api,
    ):
        assert connections(api) == {"offline"}
        with macta_fleet(kept, "--broker", broker.url, *SPEED) as fleet:
            awaited(lambda: connections(api), {"online"}.__eq__, GIVE_UP_S)
            mission = started(api, "move sample_1 to bay_7")
            broker.kill()
            time.sleep(1.0)
            broker.start()
            kill_family(process_of_the_world(fleet.pid, kept))
            assert ended(api, mission)["state"] == "completed"
            assert place_of(api, "sample_1") == "bay_7"

            fleet.send_signal(signal.SIGTERM)
            assert fleet.wait(timeout=60) == 0
            awaited(lambda: connections(api), {"offline"}.__eq__, GIVE_UP_S)
            assert snapshot_truth(kept).samples["sample_1"].ref == "bay_7"

        with macta_fleet(kept, "--broker", broker.url, "--afresh", *SPEED) as fleet:
            awaited(lambda: place_of(api, "sample_1"), "door_1".__eq__, GIVE_UP_S)
            awaited(lambda: connections(api), {"online"}.__eq__, GIVE_UP_S)
            fleet.kill()
            awaited(lambda: connections(api), {"connection_broken"}.__eq__, GIVE_UP_S)
        assert api.get("/readyz").status_code == 200
