"""A simulated robot's sensor is replaced by its virtual counterpart while it works."""

from collections.abc import Callable
from typing import Any

from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.api.test_rules import told
from tests.app.fake_robots import FakeTeam
from tests.app.missions.test_factsheets import CHANGES, started

Follow = Callable[..., dict[str, Any]]
SENSORS = "/v1/robots/yard_1/sensors"


def put(api: TestClient, source: str, sensor: str = "ultrasonic") -> Any:
    return api.put(f"{SENSORS}/{sensor}", json={"source": source})


def test_a_ring_is_virtual_and_real_again_while_a_mission_needs_the_robot(
    api: TestClient, team: FakeTeam, service: Service, follow: Follow
) -> None:
    team.faults.silent.add("yard_1")
    follow(started(api, follow, "send yard_1 to door_2"), "dispatching", "running", "unknown")
    assert [(one["sensor"], one["source"]) for one in api.get(SENSORS).json()["items"]] == [
        ("ultrasonic", "real")
    ]
    virtual = put(api, "virtual")
    assert (virtual.status_code, virtual.json()["source"], virtual.json()["edition"]) == (200, "virtual", 1)
    assert put(api, "virtual").json()["edition"] == 1, "nothing is changed twice"
    layout = api.get("/v1/worlds/sample_store").json()["layout"]
    assert next(one["sonar"] for one in layout["robots"] if one["name"] == "yard_1") == ["map", "virtual"]
    less = {"edit": "change_robot", "name": "yard_1", "sonar": ["virtual"]}
    refused = api.post(CHANGES, json={"edits": [less], "reason": "no ring"})
    assert refused.status_code == 409, "the mission needs the ring"
    assert put(api, "real").json()["source"] == "real"
    reasons = [one["reason"] for one in told(service, "world.changed")]
    assert reasons == ["the ultrasonic ring of yard_1 is virtual", "the ultrasonic ring of yard_1 is real"]


def test_what_has_no_virtual_counterpart_is_refused(api: TestClient) -> None:
    unknown = put(api, "virtual", "gripper")
    assert (unknown.status_code, unknown.json()["type"]) == (404, "urn:macta:problem:unknown-sensor")
    edit = {"edit": "change_robot", "name": "yard_1", "external": True}
    api.post(CHANGES, json={"edits": [edit], "reason": "a trial"}).raise_for_status()
    refused = put(api, "virtual")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:robot-is-external")


def test_a_robot_without_a_ring_lists_none(api: TestClient) -> None:
    edit = {"edit": "change_robot", "name": "yard_1", "sonar": ["virtual"]}
    api.post(CHANGES, json={"edits": [edit], "reason": "a trial"}).raise_for_status()
    assert api.get(SENSORS).json()["items"] == []
    refused = put(api, "virtual")
    assert (refused.status_code, refused.json()["type"]) == (404, "urn:macta:problem:unknown-sensor")
    assert "yard_1 has no ultrasonic ring" in refused.json()["detail"]
