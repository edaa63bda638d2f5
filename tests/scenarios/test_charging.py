"""A robot without a home stands idle with little battery: the service has it charged, and nobody has to ask for it."""

from pathlib import Path

from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from robots.world import WorldFile, generate_world, store_shape
from sim import SimulationProcess
from tests.scenarios.services import AUTHORISED, settings
from tests.waiting import ENDED, awaited, in_state, read_until

CHARGED = 0.85
"""CHARGE lasts until 90 %, and then the robot stands there."""


def store() -> WorldFile:
    """A robot with 29 % of a small battery, away from the charger of its area."""
    shape = store_shape(samples=1, aisles=1, yard_robots=2, store_robots=1)
    data = generate_world(shape, shared_chargers=True).model_dump(mode="json")
    (robot,) = (one for one in data["robots"] if one["name"] == "yard_2")
    data["robots"] = [robot | {"battery": 0.29, "battery_wh": 1.0}]
    return WorldFile.model_validate(data)


def test_an_idle_robot_without_a_home_ends_charged(tmp_path: Path, worker: PlanningWorker) -> None:
    """The world stands until the mission begins: its battery would last for minutes, which a busy machine may take."""
    world = store()
    with SimulationProcess.start(world, speed=None, jitter_m=0.0) as simulation:
        simulation.pause()
        running = RunningWorld(
            file=world, link=simulation.link, clock=simulation, rate=None, run=simulation.run
        )
        with (
            Service(settings(tmp_path), [running], worker=worker) as service,
            TestClient(service.api, headers=AUTHORISED) as api,
        ):
            (goal,) = awaited(lambda: api.get("/v1/goals").json()["items"], bool)
            assert (goal["text"], goal["created_by"]) == ("charge yard_2", "low_battery")
            committed = in_state(api, f"/v1/goals/{goal['id']}", "committed", "unsolvable")
            simulation.pause(paused=False)
            mission = in_state(api, f"/v1/missions/{committed['mission_id']}", *ENDED)
            assert (mission["state"], mission["reason"]) == ("completed", "")
            read_until(api, "/v1/robots/yard_2", lambda robot: robot["battery"] > CHARGED)
