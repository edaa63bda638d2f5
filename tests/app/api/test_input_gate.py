"""Text that misleads, numbers in other digits and malformed headers are refused by name, before a route sees them."""

import asyncio
import logging
from collections.abc import Iterator

import httpx2
import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient
from starlette.types import Message, Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect

from app.api import problems
from app.api.input_gate import MAX_BODY_BYTES, InputGate, refused_character
from tests.app.conftest import TOKEN

HIDDEN = {
    "\0": "U+0000",
    "\x1b": "U+001B",
    "\x85": "U+0085",
    "\u200b": "U+200B",
    "\u202e": "U+202E",
    "\u2066": "U+2066",
    "\u2028": "U+2028",
    "\ufeff": "U+FEFF",
}
FACTS = "/v1/worlds/sample_store/facts"
GOALS = "/v1/goals"


@pytest.fixture
def visitor(shared_api: TestClient) -> Iterator[TestClient]:
    """A client that is answered 500 instead of seeing the exception."""
    with TestClient(
        shared_api.app, headers={"authorization": f"Bearer {TOKEN}"}, raise_server_exceptions=False
    ) as client:
        yield client


def slots(answer: httpx2.Response) -> list[str]:
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    return [error["slot"] for error in answer.json()["errors"]]


def message(answer: httpx2.Response) -> str:
    text: str = answer.json()["errors"][0]["message"]
    return text


@pytest.mark.parametrize("character", HIDDEN, ids=HIDDEN.values())
def test_a_hidden_character_is_refused_by_name_wherever_it_stands(
    visitor: TestClient, character: str
) -> None:
    quoted = "".join(f"%{byte:02x}" for byte in character.encode())
    fact = {"predicate": "in", "args": ["sample_1", f"bay_{character}7"]}
    answers = {
        "path": visitor.get(f"/v1/goals/goal-1{quoted}"),
        "query.after": visitor.get(f"/v1/goals?after=a~b{quoted}"),
        "query": visitor.get(f"/v1/goals?a{quoted}=1"),
        "body.text": visitor.post(GOALS, json={"text": f"move sample_1{character} to bay_7"}),
        "body.facts.0.args.1": visitor.put(FACTS, json={"facts": [fact]}),
        "body": visitor.post(GOALS, json={f"te{character}xt": "move sample_1 to bay_7"}),
    }
    for slot, answer in answers.items():
        assert slots(answer) == [slot]
        assert HIDDEN[character] in message(answer)


def test_a_lone_surrogate_is_refused_in_bodies_and_in_addresses(visitor: TestClient) -> None:
    json = {"content-type": "application/json"}
    for text in (r'{"text": "move \ud800"}', r'{"text": "\udfff"}'):
        answer = visitor.post(GOALS, content=text, headers=json)
        assert slots(answer) == ["body.text"]
        assert "surrogate" in message(answer)
    assert slots(visitor.post(GOALS, content=r'{"\ud800": 1}', headers=json)) == ["body"]
    assert slots(visitor.get("/v1/goals/%ed%a0%80")) == ["path"]
    assert slots(visitor.get("/v1/goals?world=%ff")) == ["query.world"]


def test_text_in_several_lines_and_in_any_script_is_taken(visitor: TestClient) -> None:
    tuning = "/v1/robots/yard_1/tuning"
    comment = "langsam:\n\tКамень, 石, حجر, é"
    answer = visitor.put(tuning, json={"tuning": {}, "comment": comment})
    assert (answer.status_code, answer.json()["comment"]) == (200, comment)


@pytest.mark.parametrize(
    "path", ["/v1/goals/{}", "/v1/plans/{}", "/v1/missions/{}/recording", "/v1/robots/{}"]
)
def test_an_id_beyond_its_length_is_refused_by_name(visitor: TestClient, path: str) -> None:
    assert slots(visitor.get(path.format("x" * 121)))[0].startswith("path.")
    # As many characters, but more bytes than a file may have in its name.
    assert visitor.get(path.format("石" * 120)).status_code == 404


def test_names_in_bodies_and_queries_beyond_their_length_are_refused_by_name(visitor: TestClient) -> None:
    long = "x" * 121
    assert slots(visitor.get(f"/v1/robots?world={long}")) == ["query.world"]
    assert slots(visitor.post(GOALS, json={"world": long, "text": "move sample_1 to bay_7"})) == [
        "body.world"
    ]
    fact = {"predicate": "in", "args": ["sample_1", long]}
    assert slots(visitor.put(FACTS, json={"facts": [fact]})) == ["body.facts.0.args.1"]


@pytest.mark.parametrize(
    ("text", "code", "thing"),
    [
        ("move sample_1０ to bay_7", "unknown-sample", "sample_1０"),
        ("move sample_1 to bay_７", "unknown-place", "bay_７"),
        ("move sample_1² to bay_7", "unknown-sample", "sample_1²"),
    ],
)
def test_a_name_in_other_digits_is_refused_with_the_choices(
    visitor: TestClient, text: str, code: str, thing: str
) -> None:
    answer = visitor.post(GOALS, json={"text": text})
    assert (answer.status_code, answer.json()["type"]) == (422, f"urn:macta:problem:{code}")
    assert thing in answer.json()["detail"]
    assert {"sample_1", "bay_7"} & set(answer.json()["choices"])


@pytest.mark.parametrize("etag", ["²", "9" * 5000, '"', "seven", '"7', "-1", "1_000", "１"])
def test_a_version_that_is_none_is_refused_by_name(visitor: TestClient, etag: str) -> None:
    correction = {"facts": [{"predicate": "in", "args": ["sample_1", "door_1"]}]}
    answer = visitor.put(FACTS, json=correction, headers={"if-match": etag.encode()})
    assert slots(answer) == ["header.if-match"]


@pytest.mark.parametrize("etag", ["*", None])
def test_any_version_will_do_if_none_is_named(visitor: TestClient, etag: str | None) -> None:
    headers = {} if etag is None else {"if-match": etag}
    answer = visitor.put("/v1/robots/yard_2/tuning", json={"tuning": {}}, headers=headers)
    assert answer.status_code == 200


@pytest.mark.parametrize("key", ["", "x" * 201, "é".encode(), b"\xe2\x80\xae"])
def test_an_idempotency_key_that_is_none_is_refused_by_name(visitor: TestClient, key: str | bytes) -> None:
    answer = visitor.post(GOALS, json={"text": "x"}, headers={"idempotency-key": key})
    assert slots(answer) == ["header.idempotency-key"]


@pytest.mark.parametrize("header", [{"origin": "http://["}, {"origin": "http://a:b"}, {"host": "["}])
def test_a_malformed_host_or_origin_is_refused(visitor: TestClient, header: dict[str, str]) -> None:
    (name,) = header
    assert slots(visitor.post(GOALS, json={}, headers=header)) == [f"header.{name}"]


def test_a_malformed_host_or_origin_opens_nothing_to_a_stranger(visitor: TestClient) -> None:
    del visitor.headers["authorization"]
    visitor.get(f"/?token={TOKEN}")
    assert visitor.post(GOALS, json={}, headers={"origin": "http://["}).status_code == 401
    visitor.cookies.clear()
    assert visitor.get("/nowhere?token=x", headers={"host": "["}).status_code == 401


@pytest.mark.parametrize("path", ["/viewer/%00", "/viewer/a%0ab", "/viewer/%ff", "/%00", "/index.html%00"])
def test_addresses_of_the_view_and_the_console_pass_the_same_gate(visitor: TestClient, path: str) -> None:
    assert slots(visitor.get(path)) == ["path"]


def test_a_socket_with_a_hidden_character_in_its_address_is_closed(visitor: TestClient) -> None:
    with pytest.raises(WebSocketDisconnect) as closed, visitor.websocket_connect("/v1/views/a%00"):
        pass
    assert closed.value.code == 1008


def test_a_body_that_is_too_large_is_a_problem_with_the_security_headers(visitor: TestClient) -> None:
    def pieces() -> Iterator[bytes]:
        for _ in range(MAX_BODY_BYTES // 100_000 + 1):
            yield b" " * 100_000

    fits = b" " * MAX_BODY_BYTES
    declared, streamed = (visitor.post(GOALS, content=body) for body in (fits + b" ", pieces()))
    for answer in (declared, streamed, visitor.get(GOALS, headers={"content-length": "9" * 30})):
        assert (answer.status_code, answer.json()["type"]) == (413, "urn:macta:problem:too-large")
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.headers["x-content-type-options"] == "nosniff"
    assert visitor.post(GOALS, content=fits).status_code == 422


def test_a_stranger_is_asked_for_the_token_before_the_body_is_looked_at(visitor: TestClient) -> None:
    del visitor.headers["authorization"]
    answer = visitor.post(GOALS, content=b" " * (MAX_BODY_BYTES + 1))
    assert answer.status_code == 401
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_a_request_whose_client_left_before_its_body_came_is_not_carried_out() -> None:
    """A decision without a body is one without a comment: a body that never came must not be taken for that."""
    reached: list[Scope] = []

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        reached.append(scope)

    async def receive() -> Message:
        return messages.pop(0)

    async def send(_: Message) -> None:
        raise AssertionError("nobody is there to be answered")

    scope: Scope = {"type": "http", "path": "/", "query_string": b"", "headers": []}
    messages: list[Message] = [
        {"type": "http.request", "body": b"{", "more_body": True},
        {"type": "http.disconnect"},
    ]
    asyncio.run(InputGate(app)(scope, receive, send))
    assert not reached


def test_a_path_in_the_log_cannot_forge_a_line(caplog: pytest.LogCaptureFixture) -> None:
    app = FastAPI()
    problems.install(app)

    @app.get("/{name}")
    def fails(name: str) -> None:
        raise RuntimeError(name[:0])

    with TestClient(app, raise_server_exceptions=False) as client, caplog.at_level(logging.ERROR):
        assert client.get("/a%0a2026-11-22%20ERROR%20forged").status_code == 500
    (record,) = [one for one in caplog.records if one.name == "app.api.problems"]
    assert record.getMessage() == "GET /a%0A2026-11-22%20ERROR%20forged failed"


def test_the_place_of_a_refused_character_is_told() -> None:
    assert refused_character("bay_7") is None
    assert refused_character("a\u202eb") == (
        "character 2 is U+202E (right-to-left override), which is not accepted"
    )
