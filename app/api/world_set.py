"""Routes that add and remove whole worlds."""

import json
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import JSONResponse
from pydantic import BaseModel

from app.api.bodies import WorldBody
from app.api.event_schema import REF
from app.api.goals import ACTOR
from app.api.input_gate import refused_in
from app.api.parameters import Id
from app.api.problems import declared, malformed, problem
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.domain.errors import Invalid
from app.missions.world_set import WorldSet
from robots.world import WorldFile, WorldFileError

JSON_TYPE = "application/json"
YAML_TYPES = ("application/yaml", "application/x-yaml", "text/yaml")
ORIGIN = "the body"
WORLD_FILE = "WorldFile"
"""The schema of world files in the API's reference."""
MAX_RATE = 1000.0

Reason = Annotated[str, Query(max_length=2000, examples=["a second hall"])]
Rate = Annotated[
    float | None,
    Query(
        gt=0,
        le=MAX_RATE,
        description="world seconds per wall-clock second; default: the service's. Fleets choose their own",
    ),
]
REQUEST: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "description": "a world file",
        "content": {
            JSON_TYPE: {"schema": {"$ref": REF.format(model=WORLD_FILE)}},
            YAML_TYPES[0]: {"schema": {"type": "string"}},
        },
    }
}


class CheckedWorld(BaseModel):
    """A world that could be added."""

    name: str
    title: str
    robots: list[str]
    locations: list[str]
    samples: list[str]


async def _text(request: Request) -> str:
    """The body, whose content type says what it is.

    :raises Invalid: if it is no text, or neither JSON nor YAML.
    """
    kind = request.headers.get("content-type", JSON_TYPE).partition(";")[0].strip().lower()
    if kind not in (JSON_TYPE, *YAML_TYPES):
        raise Invalid(
            f"a world file is sent as JSON or YAML, not as {kind!r}",
            code="unknown-content-type",
            choices=[JSON_TYPE, *YAML_TYPES],
        )
    try:
        text = (await request.body()).decode()
        return _as_yaml(text) if kind == JSON_TYPE else text
    except (ValueError, RecursionError) as error:
        raise Invalid(f"{ORIGIN} cannot be read: {error}", code="invalid-world") from error


def _as_yaml(text: str) -> str:
    """JSON as YAML's loader reads it: a character that JSON escapes as two halves is written out.

    :raises ValueError: if it is not JSON.
    """
    document = json.loads(text)
    return json.dumps(document, ensure_ascii=False, indent=2) if "\\u" in text else text


Body = Annotated[str, Depends(_text)]
"""A world file as text."""


def world_set_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.post(
        "/worlds",
        status_code=201,
        response_model=WorldBody,
        openapi_extra=REQUEST,
        responses=declared(400, 409, 413, 429),
    )
    def add_world(
        services: AppServices, text: Body, response: Response, rate: Rate = None, reason: Reason = ""
    ) -> Any:
        """Add a world while the service and missions in other worlds run. The body is its file.

        It is known at once, so goals may be stated; its `status` is `starting` until its simulation is built, or
        `waiting_for_fleet` where fleets drive the worlds. It starts again with the service. 409 names what is in use.
        """
        world = _read(services.world_set, text)
        if isinstance(world, JSONResponse):
            return world
        services.world_set.add(world, rate=rate, actor=ACTOR, reason=reason)
        response.headers["location"] = f"/v1/worlds/{world.name}"
        return WorldBody.model_validate(services.worlds.get(world.name), from_attributes=True)

    @router.post(
        "/worlds:check",
        response_model=CheckedWorld,
        openapi_extra=REQUEST,
        responses=declared(400, 409, 413, 429),
    )
    def check_world(services: AppServices, text: Body, rate: Rate = None) -> Any:
        """Whether a world could be added; errors as those of adding it."""
        world = _read(services.world_set, text)
        if isinstance(world, JSONResponse):
            return world
        services.world_set.check(world, rate=rate)
        return CheckedWorld(
            name=world.name,
            title=world.title,
            robots=[robot.name for robot in world.robots],
            locations=[location.name for location in world.locations],
            samples=[sample.name for sample in world.samples],
        )

    @router.delete("/worlds/{world_id}", status_code=204, responses=declared(409))
    def remove_world(services: AppServices, world_id: Id, reason: Reason = "") -> None:
        """Remove a world that was added: its simulation ends, its robots disappear, its history stays.

        409 names the missions and goals that are open there. A world that was given at the start is not removed.
        """
        services.world_set.remove(world_id, actor=ACTOR, reason=reason)

    return router


def _read(worlds: WorldSet, text: str) -> WorldFile | JSONResponse:
    """The world, or the problem with it."""
    try:
        world = worlds.read(text, ORIGIN)
    except WorldFileError as error:
        faults = [{"slot": "body", "message": fault} for fault in error.faults or (str(error),)]
        return problem(422, "invalid-world", str(error), errors=faults)
    misfits = list(refused_in(world.model_dump(mode="json")))
    return malformed(misfits) if misfits else world
