"""Production: the service, the fleet that drives the world, and the broker between them, each a process of its own."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.serving import Served, macta_fleet, macta_serve

pytestmark = [needs_mosquitto, pytest.mark.timeout(600)]
GIVE_UP_S = 200.0
SPEED = ("--speed", "4")


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    with mosquitto(tmp_path / "broker") as broker:
        yield broker


def client(served: Served) -> httpx2.Client:
    return httpx2.Client(
        base_url=served.address, headers={"authorization": f"Bearer {served.token}"}, timeout=20
    )


def until(read: Callable[[], Any], holds: Callable[[Any], bool]) -> Any:
    give_up = time.monotonic() + GIVE_UP_S
    while not holds(thing := read()):
        assert time.monotonic() < give_up, thing
        time.sleep(0.1)
    return thing


def connections(api: httpx2.Client) -> set[str]:
    return {robot["connection"] for robot in api.get("/v1/robots").json()["items"]}


def started(api: httpx2.Client, text: str) -> str:
    """The path of a mission that is under way."""
    goal = api.post("/v1/goals", json={"text": text, "auto_approve": True}).json()
    committed = until(
        lambda: api.get(f"/v1/goals/{goal['id']}").json(), lambda g: g["mission_id"] is not None
    )
    mission = f"/v1/missions/{committed['mission_id']}"
    until(lambda: api.get(mission).json(), lambda m: m["state"] == "running")
    return mission


def ended(api: httpx2.Client, mission: str) -> dict[str, Any]:
    over = ("completed", "partially_completed", "failed", "cancelled")
    found: dict[str, Any] = until(lambda: api.get(mission).json(), lambda m: m["state"] in over)
    return found


def place_of(api: httpx2.Client, sample: str) -> str:
    facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
    (place,) = (f["args"][1] for f in facts if f["predicate"] == "in" and f["args"][0] == sample)
    return str(place)


def test_a_mission_is_carried_out_over_a_broker_that_is_killed_and_restarted_meanwhile(
    tmp_path: Path, broker: Mosquitto
) -> None:
    with (
        macta_serve(tmp_path / "serve", broker_url=broker.url) as served,
        client(served) as api,
    ):
        assert connections(api) == {"offline"}
        with macta_fleet(tmp_path / "fleet", "--broker", broker.url, *SPEED) as fleet:
            until(lambda: connections(api), {"online"}.__eq__)
            mission = started(api, "move sample_1 to bay_7")
            broker.kill()
            time.sleep(1.0)
            broker.start()
            assert ended(api, mission)["state"] == "completed"
            assert place_of(api, "sample_1") == "bay_7"

            fleet.kill()
            until(lambda: connections(api), {"connection_broken"}.__eq__)
        assert api.get("/readyz").status_code == 200
