"""The API's reference: what it declares is what is sent."""

import json
from typing import Any

import pytest
from fastapi.testclient import TestClient

PROBLEM = {"schema": {"$ref": "#/components/schemas/Problem"}}
WITH_BODY = ("post", "put")


@pytest.fixture
def document(shared_api: TestClient) -> dict[str, Any]:
    answer = shared_api.get("/openapi.json")
    assert answer.status_code == 200
    body: dict[str, Any] = answer.json()
    return body


def operations(document: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    return [
        (f"{method} {path}", one)
        for path, found in document["paths"].items()
        for method, one in found.items()
    ]


def test_every_error_is_declared_as_a_problem(document: dict[str, Any]) -> None:
    assert "HTTPValidationError" not in json.dumps(document)
    for name, operation in operations(document):
        for status, response in operation["responses"].items():
            if status >= "400":
                assert response["content"] == {"application/problem+json": PROBLEM}, (name, status)


def test_every_operation_declares_that_what_it_is_sent_may_not_fit(document: dict[str, Any]) -> None:
    for name, operation in operations(document):
        assert "422" in operation["responses"], name
        assert ("413" in operation["responses"]) == ("requestBody" in operation), name


def test_every_reference_leads_somewhere(document: dict[str, Any]) -> None:
    def walk(part: Any) -> None:
        if isinstance(part, dict):
            if isinstance(ref := part.get("$ref"), str):
                assert ref.removeprefix("#/components/schemas/") in document["components"]["schemas"], ref
            for value in part.values():
                walk(value)
        elif isinstance(part, list):
            for value in part:
                walk(value)

    walk(document)


def test_a_malformed_request_is_answered_with_the_declared_problem(
    shared_api: TestClient, document: dict[str, Any]
) -> None:
    body = shared_api.post("/v1/goals", json={}).json()
    declared = document["components"]["schemas"]["Problem"]
    assert set(declared["required"]) <= body.keys() <= set(declared["properties"])
    assert body["errors"][0].keys() == {"slot", "message"}


def test_the_stream_of_events_is_described_by_their_schemas(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    stream = document["paths"]["/v1/events"]["get"]["responses"]["200"]["content"]["text/event-stream"]
    assert stream["itemSchema"]["properties"]["data"]["contentSchema"] == {
        "$ref": "#/components/schemas/Event"
    }
    assert {"$ref": "#/components/schemas/GoalSubmitted"} in schemas["Event"]["oneOf"]
    assert schemas["GoalSubmitted"]["description"]
