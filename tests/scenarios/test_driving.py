"""An operator drives a robot of a whole service by hand: over the pipe of its own world, and over a broker."""

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.planning.pool.pool import PlanningWorker
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.scenarios.services import AUTHORISED, over_broker, over_pipe
from tests.scenarios.serving import macta_fleet
from tests.waiting import read_until, until

YARD = "/v1/robots/yard_1"
SPEED = 4.0


@contextmanager
def embedded(folder: Path, worker: PlanningWorker) -> Iterator[Service]:
    with over_pipe(folder, worker, speed=SPEED) as service:
        yield service


@contextmanager
def behind_a_broker(folder: Path, worker: PlanningWorker) -> Iterator[Service]:
    with (
        mosquitto(folder / "broker") as broker,
        over_broker(folder / "service", worker, broker.url) as service,
        macta_fleet(folder / "fleet", "--speed", str(SPEED), broker_url=broker.url),
    ):
        yield service


def drive(api: TestClient, as_wanted: Callable[[], bool], **wish: float) -> dict[str, Any]:
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


def stands(api: TestClient) -> tuple[complex, float]:
    """Where, and its heading."""
    pose = api.get(YARD).json()["pose"]
    return complex(pose["x_m"], pose["y_m"]), pose["heading_rad"]


def comes_to_rest(api: TestClient, service: Service) -> None:
    """Wait until it has neither moved nor turned for a second of the world's time."""
    clock = service.clocks["sample_store"]
    seen = [(clock.now_s(), stands(api))]

    def still() -> bool:
        if clock.now_s() < seen[-1][0] + 1.0:
            return False
        seen.append((clock.now_s(), stands(api)))
        (_, (was, headed)), (_, (now, heads)) = seen[-2:]
        return abs(now - was) < 0.005 and abs(heads - headed) < 0.005

    until(still, "it drives on")


@pytest.mark.parametrize(
    "running", [embedded, pytest.param(behind_a_broker, marks=needs_mosquitto)], ids=["pipe", "broker"]
)
def test_a_robot_is_driven_stops_by_itself_and_is_released(
    running: Callable[[Path, PlanningWorker], AbstractContextManager[Service]],
    worker: PlanningWorker,
    tmp_path: Path,
) -> None:
    with running(tmp_path, worker) as service, TestClient(service.api, headers=AUTHORISED) as api:
        read_until(api, YARD, lambda robot: robot["connection"] == "online" and robot["pose"])
        start, _ = stands(api)
        assert drive(api, lambda: abs(stands(api)[0] - start) > 0.4, speed_m_s=0.25)["driving"]
        goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
        path = f"/v1/goals/{goal['id']}"
        _, headed = stands(api)
        # It is planned while the robot is driven.
        drive(
            api,
            lambda: bool(abs(stands(api)[1] - headed) > 0.2 and api.get(path).json()["plan_id"]),
            turn_rad_s=0.5,
        )
        # No word more: it stands, and is free a while after.
        comes_to_rest(api, service)
        read_until(api, YARD, lambda robot: robot["driven_by"] is None and robot["packet"] is None)
        planned = api.get(path).json()
        assert "yard_1" not in api.get(f"/v1/plans/{planned['plan_id']}").json()["robots"]
        # The session is over: the robot says so, and the driver is told with his next set-point.
        until(lambda: api.post(f"{YARD}:teleoperate", json={"session": "ada"}).status_code == 409)
        assert api.post(f"{YARD}:teleoperate", json={"session": "ada-again"}).status_code == 202
        api.post(f"{YARD}:end_teleoperation", json={"session": "ada-again"})
        on_record = [row for row in service.events.since(0) if row.type.startswith("teleoperation")]
        assert [row.type.rpartition(".")[2] for row in on_record][:2] == ["began", "ended"]
        assert {row.data["driver"] for row in on_record[:2]} == {"administrator (ada)"}
