"""What the streams refuse is answered as a problem before they begin."""

import pytest
from fastapi.testclient import TestClient


def test_telemetry_of_an_unknown_world_is_a_problem(shared_api: TestClient) -> None:
    answer = shared_api.get("/v1/telemetry?world=atlantis")
    assert answer.status_code == 404
    assert answer.json()["choices"] == ["sample_store"]


@pytest.mark.parametrize("seen", ["-1", str(2**63), "9" * 30, "yesterday"])
def test_an_event_id_that_cannot_be_is_a_problem(shared_api: TestClient, seen: str) -> None:
    for answer in (
        shared_api.get("/v1/events", headers={"last-event-id": seen}),
        shared_api.get(f"/v1/events?after={seen}"),
    ):
        assert answer.status_code == 422
        assert answer.headers["content-type"] == "application/problem+json"
