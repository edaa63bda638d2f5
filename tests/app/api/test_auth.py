"""Nothing is reachable without the token but the health of the service; errors are problems that show the way out."""

import pytest
from fastapi.testclient import TestClient
from starlette.responses import PlainTextResponse

from app.api.auth import SESSION_S, TokenCheck, TokenMiddleware
from app.composition import Service
from tests.app.conftest import TOKEN
from tests.app.stepped_clock import SteppedClock


@pytest.fixture
def stranger(service: Service) -> TestClient:
    return TestClient(service.api, follow_redirects=False)


def test_every_route_but_health_wants_the_token(service: Service, stranger: TestClient) -> None:
    paths = set(service.api.openapi()["paths"])
    assert {"/v1/goals", "/v1/events", "/healthz", "/readyz"} <= paths
    unlisted = {"/", "/index.html", "/viewer", "/viewer/", "/openapi.json", "/docs", "/nowhere", "/healthz/"}
    for path in (paths | unlisted) - {"/healthz", "/readyz"}:
        for method in ("GET", "POST", "PUT", "DELETE", "OPTIONS"):
            answer = stranger.request(method, path)
            assert answer.status_code == 401, f"{method} {path}"
            assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("path", ["/healthz", "/readyz"])
def test_health_is_open(stranger: TestClient, path: str) -> None:
    assert stranger.get(path).status_code == 200


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


def test_a_wrong_token_opens_nothing(stranger: TestClient) -> None:
    for token in ("", "wrong", TOKEN[:-1], TOKEN + "x"):
        assert stranger.get("/v1/goals", headers={"authorization": f"Bearer {token}"}).status_code == 401
        assert stranger.get(f"/?token={token}").status_code == 401


def test_the_console_gets_a_cookie_that_does_not_hold_the_token(stranger: TestClient) -> None:
    answer = stranger.get(f"/?token={TOKEN}")
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    cookie = answer.headers["set-cookie"]
    assert TOKEN not in cookie
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert stranger.get("/v1/goals").status_code == 200


def browser(clock: SteppedClock, address: str = "http://rover.example:8000") -> TestClient:
    """A browser at a service that answers whatever it admits."""
    door = TokenMiddleware(PlainTextResponse("inside"), TokenCheck(TOKEN, clock))
    return TestClient(door, base_url=address, follow_redirects=False)


def test_a_session_ends_when_it_has_not_been_used_for_its_time() -> None:
    clock = SteppedClock()
    console = browser(clock)
    cookie = console.get(f"/?token={TOKEN}").headers["set-cookie"]
    assert f"Max-Age={SESSION_S};" in cookie
    clock.advance(SESSION_S - 1)
    # What a browser deletes by itself a thief keeps.
    kept = {"cookie": cookie.partition(";")[0]}
    assert browser(clock).get("/", headers=kept).status_code == 200
    clock.advance(1)
    assert browser(clock).get("/", headers=kept).status_code == 401


def test_a_session_goes_on_while_it_is_used() -> None:
    clock = SteppedClock()
    console = browser(clock)
    console.get(f"/?token={TOKEN}")
    assert "set-cookie" not in console.get("/").headers
    for _ in range(4):
        clock.advance(SESSION_S * 0.6)
        assert console.get("/").status_code == 200


def test_a_session_cannot_be_prolonged_by_its_holder() -> None:
    clock = SteppedClock()
    cookie = browser(clock).get(f"/?token={TOKEN}").headers["set-cookie"].partition(";")[0]
    name, _, session = cookie.partition("=")
    ends, _, seal = session.partition(".")
    for forged in (f"{int(ends) + 1}.{seal}", f".{seal}", "." + "0" * 64, "", "9" * 5000):
        assert browser(clock).get("/", headers={"cookie": f"{name}={forged}"}).status_code == 401


@pytest.mark.parametrize(
    ("address", "name", "secure"),
    [
        ("http://rover.example:8000", "macta_session_8000", False),
        ("http://rover.example", "macta_session_80", False),
        ("https://rover.example", "macta_session_443", True),
        ("https://rover.example:8443", "macta_session_8443", True),
    ],
)
def test_the_cookie_is_named_by_its_port_and_secure_under_tls(address: str, name: str, secure: bool) -> None:
    console = browser(SteppedClock(), address)
    cookie = console.get(f"/?token={TOKEN}").headers["set-cookie"]
    assert cookie.partition("=")[0] == name
    assert ("Secure" in cookie.split("; ")) == secure
    assert console.get("/").status_code == 200


def test_a_service_at_another_port_of_the_host_does_not_take_the_cookie() -> None:
    clock = SteppedClock()
    console = browser(clock)
    console.get(f"/?token={TOKEN}")
    assert console.get("http://rover.example:8001/").status_code == 401


@pytest.mark.parametrize("token", ["", "short"])
def test_a_token_that_protects_nothing_is_no_token(token: str) -> None:
    with pytest.raises(ValueError, match="at least 16 are needed"):
        TokenCheck(token)


def test_another_site_cannot_act_in_the_operators_name(stranger: TestClient) -> None:
    stranger.get(f"/?token={TOKEN}")
    goal = {"text": "move sample_1 to bay_7"}
    foreign = stranger.post("/v1/goals", json=goal, headers={"origin": "http://evil.example"})
    assert foreign.status_code == 401
    assert stranger.get("/v1/goals").json()["items"] == []
    own = stranger.post("/v1/goals", json=goal, headers={"origin": "http://testserver"})
    assert own.status_code == 202


def test_pages_carry_a_strict_content_policy(api: TestClient) -> None:
    policy = api.get("/").headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "unsafe" not in policy


def test_answers_of_the_api_are_not_kept_by_browsers_and_the_console_is(api: TestClient) -> None:
    assert api.get("/v1/goals").headers["cache-control"] == "no-store"
    assert api.get("/v1/goals/none").headers["cache-control"] == "no-store"
    assert "no-store" not in api.get("/main.js").headers.get("cache-control", "")


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
