"""Answers are packed for operators far away, but for what is packed already or must go out as it comes."""

from fastapi.testclient import TestClient


def test_what_is_worth_it_is_packed_for_clients_that_take_it(api: TestClient) -> None:
    packed = api.get("/main.js")
    assert packed.headers["content-encoding"] == "gzip"
    assert int(packed.headers["content-length"]) < len(packed.content) / 2
    assert api.get("/openapi.json").headers["content-encoding"] == "gzip"
    plain = api.get("/main.js", headers={"accept-encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert plain.content == packed.content


def test_what_is_small_is_not_packed(api: TestClient) -> None:
    assert "content-encoding" not in api.get("/v1/goals").headers


def test_events_go_out_as_they_come(api: TestClient) -> None:
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()["id"]
    with api.stream("GET", "/v1/events") as answer:
        assert "content-encoding" not in answer.headers
        assert any(goal in line for line in answer.iter_lines())
