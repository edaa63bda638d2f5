"""An operator looks into a robot's synthesis, and tunes its packets."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.wire import TracedPattern, TracedStretch, TracedTick, TraceReport
from robots.world import WorldFile
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.waiting import read_until

TRACE, TUNING = "/v1/robots/yard_1/trace", "/v1/robots/yard_1/tuning"
SLOW = {"NAVIGATE": {"translate/advance": {"r.gain": 0.5}}}
STRETCH = TracedStretch(
    packet_id="move",
    patterns=(TracedPattern(name="translate/advance", level="task"),),
    dofs=("translate",),
    ticks=(
        TracedTick(
            at_s=1.0, patterns=((0.5, 1.0),), resultants=((0.5, 1.0),), linear_m_s=0.2, angular_rad_s=0.0
        ),
    ),
)


def until(api: TestClient, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    return read_until(api, TUNING, holds)


def events(service: Service, type_: str) -> list[dict[str, Any]]:
    return [row.data for row in service.events.since(0) if row.type == type_]


def test_the_trace_is_what_the_robot_tells(api: TestClient, team: FakeTeam, patient: None) -> None:
    team.traced = TraceReport(at_s=1.0, stretches=(STRETCH,))
    answer = api.get(TRACE, params={"seconds": 2})
    assert answer.status_code == 200
    assert answer.json() == team.traced.model_dump(mode="json")


def test_a_robot_that_is_silent_is_said_to_be_so(api: TestClient, team: FakeTeam) -> None:
    team.faults.silent.add("yard_1")
    answer = api.get(TRACE)
    assert (answer.status_code, answer.json()["type"]) == (504, "urn:macta:problem:robot-silent")
    assert answer.json()["detail"].startswith("yard_1 has not answered within 0.6 s")


@pytest.mark.parametrize(
    ("path", "status", "names"),
    [
        ("/v1/robots/nobody/trace", 404, "unknown robot 'nobody'"),
        (f"{TRACE}?seconds=61", 422, "less than or equal to 60"),
        ("/v1/robots/nobody/tuning", 404, "unknown robot 'nobody'"),
    ],
)
def test_what_cannot_be_asked_is_refused_by_name(api: TestClient, path: str, status: int, names: str) -> None:
    answer = api.get(path)
    assert answer.status_code == status
    assert names in answer.json()["detail"]


def test_tuning_is_delivered_kept_and_recorded(api: TestClient, team: FakeTeam, service: Service) -> None:
    before = api.get(TUNING)
    assert (before.headers["etag"], before.json()["delivery"]) == ('"0"', "untouched")
    team.faults.lost = 1
    put = api.put(TUNING, json={"tuning": SLOW, "comment": "gently"}, headers={"if-match": '"0"'})
    assert (put.status_code, put.headers["etag"]) == (200, '"1"')
    tuned = until(api, lambda tuning: tuning["delivery"] == "acknowledged")
    assert team.robots["yard_1"].tunings == [SLOW]
    assert tuned["packets"]["NAVIGATE"]["translate/advance"]["r.gain"] == 0.5
    assert tuned["packets"]["NAVIGATE"]["rotate/steer"]["r.gain"] == 1.0
    assert (tuned["comment"], tuned["decided_by"]) == ("gently", "administrator")
    (said,) = events(service, "tuning.set")
    assert (said["actor"], said["version"], said["tuning"]) == ("administrator", 1, SLOW)


def test_tuning_from_an_outdated_version_is_refused(api: TestClient) -> None:
    assert api.put(TUNING, json={"tuning": SLOW}).status_code == 200
    late = api.put(TUNING, json={"tuning": {}}, headers={"if-match": '"0"'})
    assert (late.status_code, late.json()["type"]) == (412, "urn:macta:problem:tuning-changed")
    assert api.get(TUNING).json()["tuning"] == SLOW


@pytest.mark.parametrize(
    ("tuning", "names"),
    [
        ({"FLY": {}}, "yard_1 has no packet FLY; its packets:"),
        ({"NAVIGATE": {"translate/fly": {"r.gain": 1}}}, "NAVIGATE has no pattern translate/fly"),
        (
            {"NAVIGATE": {"translate/advance": {"r.limit": 2}}},
            "NAVIGATE: translate/advance: r.limit = 2.0: Input should be less than or equal to 1",
        ),
        ({"NAVIGATE": {"translate/advance": {"r.gain": "fast"}}}, "valid number"),
    ],
)
def test_tuning_that_does_not_fit_is_refused_by_packet_pattern_and_parameter(
    api: TestClient, tuning: dict[str, Any], names: str
) -> None:
    answer = api.put(TUNING, json={"tuning": tuning})
    assert answer.status_code == 422
    assert names in answer.json()["detail"]
    assert api.get(TUNING).json()["version"] == 0


def test_tuning_that_the_robot_refuses_says_so(api: TestClient, team: FakeTeam) -> None:
    team.faults.refuses.add("yard_1")
    api.put(TUNING, json={"tuning": SLOW})
    assert until(api, lambda tuning: tuning["delivery"] == "refused")["detail"] == "not willing"


def test_a_world_that_is_started_again_receives_the_tuning_again(
    tmp_path: Path, world_file: WorldFile, worker: PlanningWorker
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=None)
    for start in range(2):
        with FakeTeam(run=f"run {start}") as team:
            world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
            with Service(settings, [world], worker=worker) as service, TestClient(service.api) as api:
                api.headers["authorization"] = f"Bearer {TOKEN}"
                if start == 0:
                    assert api.put(TUNING, json={"tuning": SLOW}).status_code == 200
                until(api, lambda tuning: tuning["delivery"] == "acknowledged")
                assert team.robots["yard_1"].tunings == [SLOW]
