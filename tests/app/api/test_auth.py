"""Nothing is reachable without the token but the health of the service; errors are problems that show the way out."""

import pytest
from fastapi.testclient import TestClient

from app.composition import Service
from tests.app.conftest import TOKEN


@pytest.fixture
def stranger(service: Service) -> TestClient:
    return TestClient(service.api, follow_redirects=False)


@pytest.fixture
def shared_stranger(shared_service: Service) -> TestClient:
    return TestClient(shared_service.api, follow_redirects=False)


def test_every_route_but_health_wants_the_token(shared_service: Service, shared_stranger: TestClient) -> None:
    paths = set(shared_service.api.openapi()["paths"])
    assert {"/v1/goals", "/v1/events", "/healthz", "/readyz"} <= paths
    unlisted = {"/", "/index.html", "/viewer", "/viewer/", "/openapi.json", "/docs", "/nowhere", "/healthz/"}
    for path in (paths | unlisted) - {"/healthz", "/readyz"}:
        for method in ("GET", "POST", "PUT", "DELETE", "OPTIONS"):
            answer = shared_stranger.request(method, path)
            assert answer.status_code == 401, f"{method} {path}"
            assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("path", ["/healthz", "/readyz"])
def test_health_is_open(shared_stranger: TestClient, path: str) -> None:
    assert shared_stranger.get(path).status_code == 200


def test_a_world_whose_link_is_broken_makes_the_service_not_ready(
    service: Service, stranger: TestClient
) -> None:
    service.board.link_closed("sample_store")
    answer = stranger.get("/readyz")
    assert (answer.status_code, answer.json()["type"]) == (503, "urn:macta:problem:world-unreachable")
    assert "sample_store" in answer.json()["detail"]
    assert stranger.get("/healthz").status_code == 200


def test_a_defect_is_answered_as_a_problem_without_its_text_which_is_logged(
    service: Service, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise RuntimeError("the password is swordfish")

    monkeypatch.setattr(service.goals, "newest", fails)
    client = TestClient(
        service.api, headers={"authorization": f"Bearer {TOKEN}"}, raise_server_exceptions=False
    )
    answer = client.get("/v1/goals")
    assert (answer.status_code, answer.json()["type"]) == (500, "urn:macta:problem:internal")
    assert answer.headers["content-type"] == "application/problem+json"
    assert "swordfish" not in answer.text
    assert "swordfish" in caplog.text


def test_a_wrong_token_opens_nothing(shared_stranger: TestClient) -> None:
    for token in ("", "wrong", TOKEN[:-1], TOKEN + "x"):
        assert (
            shared_stranger.get("/v1/goals", headers={"authorization": f"Bearer {token}"}).status_code == 401
        )
        assert shared_stranger.get(f"/?token={token}").status_code == 401


def test_the_console_gets_a_cookie_that_does_not_hold_the_token(shared_stranger: TestClient) -> None:
    answer = shared_stranger.get(f"/?token={TOKEN}")
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"]
    assert TOKEN not in cookie
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert shared_stranger.get("/v1/goals").status_code == 200


def test_another_site_cannot_act_in_the_operators_name(stranger: TestClient) -> None:
    stranger.get(f"/?token={TOKEN}")
    goal = {"text": "move sample_1 to bay_7"}
    foreign = stranger.post("/v1/goals", json=goal, headers={"origin": "http://evil.example"})
    assert foreign.status_code == 401
    assert stranger.get("/v1/goals").json()["items"] == []
    own = stranger.post("/v1/goals", json=goal, headers={"origin": "http://testserver"})
    assert own.status_code == 202


def test_pages_carry_a_strict_content_policy(shared_api: TestClient) -> None:
    policy = shared_api.get("/").headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "unsafe" not in policy


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


def test_the_same_idempotency_key_is_the_same_goal(api: TestClient) -> None:
    key = {"idempotency-key": "from the ground station, 17"}
    first = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}, headers=key)
    second = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}, headers=key)
    other = api.post("/v1/goals", json={"text": "move sample_2 to bay_4"}, headers=key)
    assert first.json()["id"] == second.json()["id"]
    assert other.status_code == 409
    assert len(api.get("/v1/goals").json()["items"]) == 1


def test_lists_are_paged_newest_first(api: TestClient) -> None:
    ids = [api.post("/v1/goals", json={"text": f"move sample_1 to bay_{n}"}).json()["id"] for n in (7, 8, 9)]
    first = api.get("/v1/goals?limit=2").json()
    rest = api.get(f"/v1/goals?limit=2&after={first['next']}").json()
    assert [goal["id"] for goal in first["items"] + rest["items"]] == ids[::-1]
    assert rest["next"] is None
    assert api.get("/v1/goals?after=nonsense").status_code == 422


def test_facts_are_corrected_only_from_the_version_that_was_seen(api: TestClient) -> None:
    seen = api.get("/v1/worlds/sample_store/facts").headers["etag"]
    correction = {"facts": [{"predicate": "in", "args": ["sample_1", "door_2"]}]}
    first = api.put("/v1/worlds/sample_store/facts", json=correction, headers={"if-match": seen})
    assert first.status_code == 200
    second = api.put("/v1/worlds/sample_store/facts", json=correction, headers={"if-match": seen})
    assert second.status_code == 412
    items = api.get("/v1/worlds/sample_store/facts").json()["items"]
    placed = [fact for fact in items if fact["predicate"] == "in" and fact["args"][0] == "sample_1"]
    assert [(fact["args"], fact["source"]) for fact in placed] == [
        (["sample_1", "door_2"], "operator administrator")
    ]
    misfit = {"facts": [{"predicate": "in", "args": ["sample_1", "nowhere"]}]}
    assert api.put("/v1/worlds/sample_store/facts", json=misfit).status_code == 422
