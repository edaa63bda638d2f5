"""An operator drives a robot of a whole service by hand: over the pipe of its own world, and over a broker."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.mosquitto import mosquitto, needs_mosquitto
from tests.scenarios.serving import macta_fleet, macta_serve
from tests.waiting import read_until, until

pytestmark = pytest.mark.timeout(600)
YARD = "/v1/robots/yard_1"


@contextmanager
def embedded(folder: Path) -> Iterator[httpx2.Client]:
    with macta_serve(folder / "serve") as served, served.client() as api:
        yield api


@contextmanager
def over_a_broker(folder: Path) -> Iterator[httpx2.Client]:
    with ExitStack() as stack:
        broker = stack.enter_context(mosquitto(folder / "broker"))
        served = stack.enter_context(macta_serve(folder / "serve", broker_url=broker.url))
        stack.enter_context(macta_fleet(folder / "fleet", broker_url=broker.url))
        yield stack.enter_context(served.client())


def drive(api: httpx2.Client, as_wanted: Callable[[], bool], **wish: float) -> dict[str, Any]:
    """Wish the same some times a second until all is as wanted; what was told last."""
    told: dict[str, Any] = {}

    def go_on() -> bool:
        answer = api.post(f"{YARD}:teleoperate", json={"session": "ada", **wish})
        assert answer.status_code == 202, answer.text
        told.update(answer.json())
        time.sleep(0.1)
        return as_wanted()

    until(go_on, "it does not do what is wished")
    return told


def stands(api: httpx2.Client) -> tuple[complex, float]:
    """Where, and its heading."""
    pose = api.get(YARD).json()["pose"]
    return complex(pose["x_m"], pose["y_m"]), pose["heading_rad"]


def comes_to_rest(api: httpx2.Client) -> None:
    """Wait until it has neither moved nor turned for a while."""
    seen = [stands(api)]

    def still() -> bool:
        time.sleep(0.5)
        seen.append(stands(api))
        (was, headed), (now, heads) = seen[-2:]
        return abs(now - was) < 0.005 and abs(heads - headed) < 0.005

    until(still, "it drives on")


@pytest.mark.parametrize(
    "running", [embedded, pytest.param(over_a_broker, marks=needs_mosquitto)], ids=["pipe", "broker"]
)
def test_a_robot_is_driven_stops_by_itself_and_is_let_go_of(
    running: Callable[[Path], Any], tmp_path: Path
) -> None:
    with running(tmp_path) as api:
        read_until(api, YARD, lambda robot: robot["connection"] == "online" and robot["pose"])
        start, _ = stands(api)
        assert drive(api, lambda: abs(stands(api)[0] - start) > 0.4, speed_m_s=0.25)["driving"]
        goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
        _, headed = stands(api)
        drive(api, lambda: abs(stands(api)[1] - headed) > 0.2, turn_rad_s=0.5)
        # No word more: it stands, and is free a while after.
        comes_to_rest(api)
        read_until(api, YARD, lambda robot: robot["driven_by"] is None and robot["packet"] is None)
        planned = read_until(api, f"/v1/goals/{goal['id']}", lambda goal: goal["plan_id"])
        assert "yard_1" not in api.get(f"/v1/plans/{planned['plan_id']}").json()["robots"]
        # The session is over: the robot says so, and the driver is told with his next set-point.
        until(lambda: api.post(f"{YARD}:teleoperate", json={"session": "ada"}).status_code == 409)
        assert api.post(f"{YARD}:teleoperate", json={"session": "ada-again"}).status_code == 202
        api.post(f"{YARD}:end_teleoperation", json={"session": "ada-again"})
        on_record = [one for one in events(api) if one["type"].startswith("teleoperation")]
        assert [one["type"].rpartition(".")[2] for one in on_record][:2] == ["began", "ended"]
        assert {one["data"]["driver"] for one in on_record[:2]} == {"administrator (ada)"}


def events(api: httpx2.Client) -> list[dict[str, Any]]:
    """What is on record so far."""
    found: list[dict[str, Any]] = []
    with api.stream("GET", "/v1/events", params={"after": 0}, timeout=1.5) as stream:
        try:
            for line in stream.iter_lines():
                if line.startswith("data: "):
                    found.append(json.loads(line.removeprefix("data: ")))
        except httpx2.ReadTimeout:
            return found
    return found
