"""Requests that cannot be carried out are refused by name, with the choices there are."""

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from app.api.problems import install


@pytest.mark.parametrize(
    ("text", "status", "code", "named", "choice"),
    [
        ("move sample_9 to bay_7", 422, "unknown-sample", "sample_9", "sample_1"),
        ("move sample_1 to bay_77", 422, "unknown-place", "bay_77", "bay_7"),
        ("move sample_1 to bay_2", 409, "place-occupied", "sample_2", "bay_1"),
        ("move sample_1", 422, "place-needed", "sample_1", "bay_7"),
        ("juggle sample_1", 422, "unknown-verb", "juggle", "move"),
    ],
)
def test_a_goal_that_cannot_be_is_refused_by_name_with_choices_and_leaves_nothing(
    shared_api: TestClient, text: str, status: int, code: str, named: str, choice: str
) -> None:
    answer = shared_api.post("/v1/goals", json={"text": text})
    body = answer.json()
    assert (answer.status_code, body["type"]) == (status, f"urn:macta:problem:{code}")
    assert named in body["detail"]
    assert choice in body["choices"]
    assert shared_api.get("/v1/goals").json()["items"] == []


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"text": "move sample_1 to bay_7", "goal": [{"predicate": "in", "args": ["sample_1", "bay_7"]}]},
        {
            "text": "move sample_1 to bay_7",
            "goal": [{"predicate": "in", "args": ["sample_1", "bay_7"]}],
            "holds": [{"places": ["bay_5"]}],
        },
        {"text": "move sample_1 to bay_7", "urgency": 3},
        {"goal": []},
        {"text": "x" * 2000},
        {"text": "move sample_1 to bay_7", "deadline_s": -1},
    ],
)
def test_a_malformed_request_says_which_slot_is_wrong(
    shared_api: TestClient, body: dict[str, object]
) -> None:
    answer = shared_api.post("/v1/goals", json=body)
    assert answer.status_code == 422
    assert answer.json()["errors"]


def test_unknown_things_are_named(shared_api: TestClient) -> None:
    for path in (
        "/v1/goals/g",
        "/v1/plans/p",
        "/v1/missions/m",
        "/v1/robots/r",
        "/v1/worlds/w",
        "/v1/nothing",
    ):
        answer = shared_api.get(path)
        assert answer.status_code == 404
        assert answer.headers["content-type"] == "application/problem+json"
        assert path.rsplit("/", 1)[1] in answer.json()["detail"]


@pytest.mark.parametrize(
    ("things", "state"), [("goals", "committed"), ("plans", "superseded"), ("missions", "recovering")]
)
def test_a_state_that_does_not_exist_is_answered_with_those_that_do(
    shared_api: TestClient, things: str, state: str
) -> None:
    answer = shared_api.get(f"/v1/{things}?state=bogus")
    assert answer.status_code == 422
    assert state in answer.json()["detail"]
    assert shared_api.get(f"/v1/{things}?state={state}").json()["items"] == []


def test_a_request_that_gets_no_connection_to_the_database_is_told_to_come_back() -> None:
    app = FastAPI()
    install(app)

    @app.get("/any")
    def no_connection() -> None:
        raise PoolTimeoutError("all connections are in use")

    answer = TestClient(app).get("/any")
    assert answer.status_code == 503
    assert answer.json()["type"] == "urn:macta:problem:database-away"
    assert int(answer.headers["retry-after"]) > 0


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("PATCH", "/v1/goals", "GET, POST"),
        ("DELETE", "/v1/missions/m", "GET"),
        ("DELETE", "/v1/plans/p:approve", "POST"),
    ],
)
def test_a_method_that_a_path_has_not_is_refused_with_those_it_has(
    shared_api: TestClient, method: str, path: str, allowed: str
) -> None:
    answer = shared_api.request(method, path)
    assert answer.status_code == 405
    assert answer.json()["type"] == "urn:macta:problem:method-not-allowed"
    assert answer.headers["allow"] == allowed


def test_no_error_has_the_reference_made() -> None:
    """It takes half a second, in which the service answers nobody."""
    app = FastAPI()
    install(app)

    @app.get("/any")
    def any_thing() -> None:
        pass

    client = TestClient(app)
    assert client.get("/another").status_code == 404
    assert client.post("/any").status_code == 405
    assert app.openapi_schema is None
