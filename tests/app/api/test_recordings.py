"""Missions are recorded as they go, and their recordings can be had over the API."""

import io
from collections.abc import Callable, Collection, Sequence
from typing import Any

import pytest
from fastapi.testclient import TestClient
from mcap.reader import make_reader

from app.composition import Service
from app.domain.lifecycles.mission import ENDED
from app.recordings.mission_reader import MissionReader
from app.store import MissionRow
from robots.wire import Telemetry
from tests.waiting import read_until, until

Follow = Callable[..., dict[str, Any]]


def at(x_m: float, *, at_s: float = 1.0) -> Telemetry:
    return Telemetry(at_s=at_s, x_m=x_m, y_m=5.0, heading_rad=0.0, battery=0.5)


def test_a_mission_is_recorded_from_its_goal_to_its_end(
    api: TestClient, follow: Follow, service: Service
) -> None:
    service.board.heard("store_2", at(6.0))
    service.board.heard("yard_1", at(1.0))
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    mission_id = follow(f"/v1/goals/{goal['id']}", "finished")["mission_id"]
    path = f"/v1/missions/{mission_id}"
    replay = read_until(api, f"{path}/replay", ended)
    states = [one["mission"]["state"] for one in replay["missions"]]
    assert states[-1] == "completed"
    assert replay["robots"]["yard_1"] == [[1.0, 1.0, 5.0, 0.0, None, None]]
    assert replay["robots"]["store_2"] == [[1.0, 6.0, 5.0, 0.0, None, None]]
    assert [one["battery"] for one in replay["telemetry"]["store_2"]] == [0.5]
    own = {script["robot"] for script in replay["scripts"].values()}
    assert set(replay["telemetry"]) == own & set(replay["robots"])
    assert replay["world"]["layout"]["name"] == "sample_store"
    (plan,) = replay["plans"].values()
    assert plan["goals"] == [{"predicate": "in", "args": ["sample_1", "bay_7"]}]
    assert (replay["goal"]["id"], replay["goal"]["text"]) == (goal["id"], "move sample_1 to bay_7")
    assert replay["samples"][-1]["lying"]["sample_1"] == "bay_7"

    types = [event["type"] for event in replay["events"]]
    story = ["goal.submitted", "plan.proposed", "plan.approved", "mission.running", "mission.completed"]
    assert [one for one in types if one in story] == story
    numbers = [event["seq"] for event in replay["events"]]
    assert numbers == sorted(set(numbers))

    answer = api.get(f"{path}/recording")
    assert answer.headers["content-disposition"] == f'attachment; filename="{mission_id}.mcap"'
    summary = make_reader(io.BytesIO(answer.content)).get_summary()
    assert summary is not None
    assert {"/tf", "/events", "/mission", "/plan"} <= {c.topic for c in summary.channels.values()}
    kept = api.get("/v1/recordings").json()["items"]
    assert [one["mission_id"] for one in kept] == [mission_id]


def test_a_mission_that_ends_while_its_events_are_read_is_recorded_to_its_last(
    api: TestClient, follow: Follow, service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = MissionReader.missions

    def missions_that_have_ended_by_now(reader: MissionReader, ids: Collection[str]) -> Sequence[MissionRow]:
        until(lambda: all(one.state in ENDED for one in read(reader, ids)))
        return read(reader, ids)

    monkeypatch.setattr(MissionReader, "missions", missions_that_have_ended_by_now)
    service.board.heard("store_2", at(6.0))
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    mission_id = follow(f"/v1/goals/{goal['id']}", "finished")["mission_id"]
    replay = read_until(api, f"/v1/missions/{mission_id}/replay", ended)
    assert replay["robots"]["store_2"] == [[1.0, 6.0, 5.0, 0.0, None, None]]


def ended(told: dict[str, Any]) -> bool:
    lies = [one["lying"]["sample_1"] for one in told.get("samples", ())]
    return lies[-1:] == ["bay_7"] and any(event["type"] == "mission.completed" for event in told["events"])


def test_a_mission_without_a_recording_says_so(api: TestClient) -> None:
    answer = api.get("/v1/missions/mission-unheard/recording")
    assert (answer.status_code, answer.json()["type"]) == (404, "urn:macta:problem:no-recording")
