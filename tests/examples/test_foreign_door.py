"""A stranger's doors, forty lines on an MQTT client: they announce themselves, open for a robot, and fail."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import httpx2
import yaml

from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.serving import macta_serve
from tests.waiting import awaited, in_state, mission_of

EXAMPLES = Path(__file__).parents[2] / "examples"
DOOR = EXAMPLES / "foreign_door.py"
QUICK = {"speed_m_s": 2.0, "turn_rad_s": 6.0}
WORLD: Mapping[str, Any] = {
    "name": "annexe",
    "title": "Annexe",
    "compartments": [{"name": "hall", "x": [0, 8], "y": [0, 6]}],
    "walls": [
        {
            "start": [4, 0],
            "end": [4, 6],
            "openings": [
                {"kind": "gap", "at_m": 1.5, "width_m": 1.2},
                {"kind": "gap", "at_m": 4.5, "width_m": 1.2},
            ],
        }
    ],
    "locations": [
        {"name": "bay_1", "kind": "bay", "at": [0.5, 3], "approach_deg": [0]},
        {"name": "bay_2", "kind": "bay", "at": [7.5, 3], "approach_deg": [180]},
        {"name": "north_west", "kind": "place", "at": [3.2, 4.5], "approach_deg": [180], "capacity": 0},
        {"name": "north_east", "kind": "place", "at": [4.8, 4.5], "approach_deg": [0], "capacity": 0},
        {"name": "south_west", "kind": "place", "at": [3.2, 1.5], "approach_deg": [180], "capacity": 0},
        {"name": "south_east", "kind": "place", "at": [4.8, 1.5], "approach_deg": [0], "capacity": 0},
    ],
    "robots": [
        {"name": "fred", "compartment": "hall", "start": [2.5, 3.5, 0], "external": True, **QUICK},
    ],
    "samples": [{"name": "sample_1", "at": "bay_1"}],
}
NORTH = {"kind": "door", "start": [4, 3.9], "end": [4, 5.1], "opening_s": 1, "closing_s": 1}
SOUTH = {"kind": "door", "start": [4, 0.9], "end": [4, 2.1], "opening_s": 1, "closing_s": 1}


class Strangers:
    """Processes of other people's software."""

    def __init__(self, broker: Mosquitto) -> None:
        self._broker = broker
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, example: str, name: str, *arguments: str) -> None:
        """Start the software of one, again if it ran."""
        self.end(name)
        command = [
            sys.executable,
            str(EXAMPLES / example),
            "127.0.0.1",
            str(self._broker.port),
            "annexe",
            name,
        ]
        self._running[name] = subprocess.Popen([*command, *arguments])

    def end(self, name: str) -> None:
        """It is gone without a word."""
        if (process := self._running.pop(name, None)) is not None:
            assert process.poll() is None, f"{name} ended by itself"
            process.kill()
            process.wait()

    def close(self) -> None:
        for name in list(self._running):
            self.end(name)


@contextmanager
def annexe(tmp_path: Path) -> Iterator[tuple[httpx2.Client, Strangers]]:
    """A service and a robot of other people's in a world that has no doors yet."""
    path = tmp_path / "annexe.yaml"
    path.write_text(yaml.safe_dump(dict(WORLD)))
    places = {place["name"]: place["at"] for place in WORLD["locations"]}
    sheet = {"number": 1, "compartment": "hall", "start": [2.5, 3.5, 0], "senses": [], **QUICK}
    sheet["repertoire"] = ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"]
    with ExitStack() as stack:
        broker = stack.enter_context(mosquitto(tmp_path / "broker"))
        options = ("--broker", broker.url, "--world", str(path))
        served = stack.enter_context(macta_serve(tmp_path / "data", *options))
        strangers = Strangers(broker)
        stack.callback(strangers.close)
        strangers.start("foreign_robot.py", "fred", json.dumps(sheet), json.dumps(places))
        yield stack.enter_context(served.client()), strangers


def admitted(api: httpx2.Client, name: str) -> None:
    """Admit one that has announced itself, and wait until it is in the world."""
    sheets = "/v1/worlds/annexe/factsheets"
    awaited(lambda: [one["robot"] for one in api.get(sheets).json()["items"]], lambda names: name in names)
    api.post(f"/v1/worlds/annexe/robots/{name}:admit", json={"comment": ""}).raise_for_status()


def begun(api: httpx2.Client, place: str) -> str:
    """The mission that is to take the robot to the place."""
    body = {"text": f"send fred to {place}", "auto_approve": True, "recovery": "auto"}
    goal = api.post("/v1/goals", json=body).raise_for_status().json()
    return mission_of(api, goal["id"])


def ended(api: httpx2.Client, mission: str) -> tuple[str, str]:
    """How it ended: its state and reason."""
    said = in_state(api, f"/v1/missions/{mission}", "completed", "failed", "cancelled")
    return said["state"], said["reason"]


def moved_by(api: httpx2.Client, mission: str) -> set[str]:
    """Who has scripts in the mission's last plan."""
    return {one["robot"] for one in api.get(f"/v1/missions/{mission}").json()["progress"]}


def doors(api: httpx2.Client) -> dict[str, Any]:
    return {one["name"]: one for one in api.get("/v1/peripherals").json()["items"]}


def test_it_is_short_and_imports_nothing_of_ours() -> None:
    lines = [line for line in DOOR.read_text().splitlines() if line.strip()]
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 120
    assert not re.search(r"import .*\b(app|robots|planner|sim|web)\b|sha|digest", "\n".join(lines))


@needs_mosquitto
def test_a_robot_goes_through_doors_that_announced_themselves_and_by_another_if_one_fails(
    tmp_path: Path,
) -> None:
    with annexe(tmp_path) as (api, strangers):
        for name, door in (("north", NORTH), ("south", SOUTH)):
            strangers.start("foreign_door.py", name, json.dumps(door))
            admitted(api, name)
        awaited(lambda: {one["connection"] for one in doors(api).values()}, {"online"}.__eq__)

        through_north = begun(api, "bay_2")
        assert ended(api, through_north) == ("completed", "")
        assert moved_by(api, through_north) == {"fred", "north"}

        # NOTE: a mission that is planned while its connection is broken goes through the other door at once.
        strangers.end("north")
        awaited(lambda: doors(api)["north"]["connection"], "connection_broken".__eq__)
        strangers.start("foreign_door.py", "north", json.dumps(NORTH), "its motor does not move")
        awaited(lambda: doors(api)["north"]["connection"], "online".__eq__)
        back = begun(api, "bay_1")
        assert ended(api, back)[0] == "completed"
        assert moved_by(api, back) == {"fred", "south"}
        assert doors(api)["north"]["out_of_service"]["reason"] == "its motor does not move"

        strangers.end("south")
        awaited(lambda: doors(api)["south"]["connection"], "connection_broken".__eq__)
        api.post("/v1/robots/north:bring_back", json={}).raise_for_status()
        last = begun(api, "bay_2")
        awaited(lambda: "south" in moved_by(api, last), bool)
        api.post("/v1/robots/south:declare_lost", json={}).raise_for_status()
        state, reason = ended(api, last)
        assert state == "failed"
        assert "no plan was found without north, south" in reason
