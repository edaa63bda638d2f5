"""The API's reference: FastAPI's OpenAPI document, with the problems and the events as they are sent."""

from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI

from app.api.auth import OPEN_PATHS
from app.api.event_schema import ANY_EVENT, REF, event_schemas
from app.api.problems import Problem, declared
from app.api.world_set import WORLD_FILE
from robots.world import WorldFile

TOKEN_SCHEME = "token"
EVENTS_PATH = "/v1/events"
METHODS = frozenset({"get", "put", "post", "patch", "delete"})


class Api(FastAPI):
    """FastAPI with a corrected OpenAPI document.

    FastAPI declares its own body for 422, which is never sent: the handlers of `problems` answer every error.
    """

    def openapi(self) -> dict[str, Any]:
        is_made = self.openapi_schema is not None
        document = super().openapi()
        if not is_made:
            _complete(document)
        return document


def _complete(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    del schemas["HTTPValidationError"], schemas["ValidationError"]
    document["components"]["securitySchemes"] = {TOKEN_SCHEME: {"type": "http", "scheme": "bearer"}}
    problem = Problem.model_json_schema(ref_template=REF)
    schemas |= problem.pop("$defs")
    schemas[Problem.__name__] = problem
    world_file = WorldFile.model_json_schema(ref_template=REF)
    for name, schema in {**world_file.pop("$defs"), WORLD_FILE: world_file}.items():
        schemas.setdefault(name, schema)
    for name, schema in event_schemas().items():
        schemas.setdefault(name, schema)
    for path, operations in document["paths"].items():
        for method in METHODS & operations.keys():
            responses = operations[method]["responses"]
            if path not in OPEN_PATHS:
                operations[method]["security"] = [{TOKEN_SCHEME: []}]
            responses.pop("422", None)
            responses |= {
                str(status): body for status, body in declared(*_errors(path, operations[method])).items()
            }
    stream = document["paths"][EVENTS_PATH]["get"]["responses"]["200"]["content"]["text/event-stream"]
    stream["itemSchema"]["properties"]["data"]["contentSchema"] = {"$ref": REF.format(model=ANY_EVENT)}


def _errors(path: str, operation: dict[str, Any]) -> Iterator[int]:
    """The errors that any operation like this may return; others are declared by their routes."""
    if path not in OPEN_PATHS:
        yield from (401, 503)
    if "requestBody" in operation:
        yield from (400, 413)
    yield 422  # for refused characters, see `input_gate`
    if "{" in path:
        yield 404
