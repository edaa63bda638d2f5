"""A person commands one robot, which asks "which one?" (SRA): a whole service with its simulation."""

from cmath import phase, rect
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from app.planning.pool.pool import PlanningWorker
from robots.world import load_world
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.scenarios.services import AUTHORISED, over_broker, over_pipe
from tests.scenarios.serving import macta_fleet
from tests.waiting import in_state, mission_of, read_until

ROBOT = "/v1/robots/store_1"
WORDS = f"{ROBOT}/dialogues"
SPEED = 2.0
"""The longest drive takes six seconds, in which the test asks four times."""


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


class Person:
    """Somebody who speaks to store_1."""

    def __init__(self, api: TestClient) -> None:
        self.api = api

    def says(self, text: str, **more: Any) -> dict[str, Any]:
        answer = self.api.post(WORDS, json={"text": text, **more})
        assert answer.status_code == 202, answer.text
        told: dict[str, Any] = answer.json()
        return told

    def is_told(self, dialogue: dict[str, Any], state: str = "done") -> str:
        """What the robot has said last, once the dialogue is so."""
        words: str = in_state(self.api, f"{WORDS}/{dialogue['id']}", state)["lines"][-1]["words"]
        return words

    def asks(self, text: str) -> str:
        return self.is_told(self.says(text))


def off_course(api: TestClient, thing: complex) -> float:
    """The angle between the robot's heading and a thing, as its telemetry has it."""
    pose = api.get(ROBOT).json()["pose"]
    bearing = thing - complex(pose["x_m"], pose["y_m"])
    turn = phase(bearing) - pose["heading_rad"]
    return abs(phase(rect(1.0, turn)))


@pytest.mark.parametrize(
    "running", [embedded, pytest.param(behind_a_broker, marks=needs_mosquitto)], ids=["pipe", "broker"]
)
def test_a_person_commands_a_robot_which_asks_which_one(
    running: Callable[[Path, PlanningWorker], AbstractContextManager[Service]],
    worker: PlanningWorker,
    tmp_path: Path,
) -> None:
    places = {place.name: complex(*place.at) for place in load_world("sample_store").places}
    with running(tmp_path, worker) as service, TestClient(service.api, headers=AUTHORISED) as api:
        read_until(api, ROBOT, lambda robot: robot["connection"] == "online" and robot["pose"])
        person = Person(api)

        # In plain words: which one is asked, the script is shown, approved and done.
        asked = person.says("store_1, face the sample")
        assert asked["question"] == {
            "detail": "which one? sample_2 or sample_3",
            "choices": ["sample_2", "sample_3"],
        }
        shown = person.says("sample 3", dialogue=asked["id"])
        assert [packet["tag"] for packet in shown["script"]] == ["FACE_OBJECT"]
        assert person.says("yes", dialogue=asked["id"])["state"] == "said"
        assert person.is_told(asked) == "done"
        assert off_course(api, places["bay_5"]) < 0.3

        # The same in ACL, at once.
        asked = person.says("REQUEST target:store_1 action:face object:sample")
        person.says("INFORM object:sample_2", dialogue=asked["id"], approve=True)
        assert person.is_told(asked) == "done"
        assert off_course(api, places["bay_2"]) < 0.3

        # Questions are answered by the robot itself.
        assert person.asks("do you see sample_2?") == "yes, I see sample_2"
        assert person.asks("what are you doing?") == "I do nothing"
        assert person.asks("QUERY-REF property:[battery]").startswith("my battery is at ")

        # A robot under way is stopped, and what was asked of it has failed.
        going = person.says("go to bay_1", approve=True)
        in_state(api, f"{WORDS}/{going['id']}", "agreed")
        assert person.asks("stop") == "I have stopped"
        assert person.is_told(going, "failed") == "I could not: withdrawn"

        # On a mission it refuses, and stop pauses the mission, whose script stands as it was.
        goal = api.post("/v1/goals", json={"text": "send store_1 to bay_1", "auto_approve": True}).json()
        mission = mission_of(api, goal["id"])
        read_until(api, ROBOT, lambda robot: robot["mission_id"] == mission)
        refused = person.says("turn left", approve=True)
        assert (refused["state"], mission in refused["reason"]) == ("refused", True)
        assert "is paused" in person.asks("stop")
        path = f"/v1/missions/{mission}"
        in_state(api, path, "paused")
        api.post(f"{path}:resume", json={})
        in_state(api, path, "completed")
