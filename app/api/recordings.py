"""Recordings of missions: the list, the MCAP file, and the data and page of a replay."""

from collections.abc import Iterator
from dataclasses import asdict
from os import SEEK_END
from pathlib import Path
from typing import IO, Any

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, StreamingResponse
from pydantic import BaseModel, ConfigDict, Field

from app.agents.world_service import WorldService
from app.api.bodies import GoalBody, Page, plan_body
from app.api.mission_bodies import MissionBody, ResultBody
from app.api.parameters import Id
from app.planning.approval import PlanApproval
from app.recordings import RecordingStore, replay_of
from app.recordings.recorder import RecordedBodies
from app.recordings.replay_page import replay_page

MCAP = "application/x-mcap"
PIECE_BYTES = 64 * 1024


class McapResponse(StreamingResponse):
    media_type = MCAP


class RecordingBody(BaseModel):
    """The recording of a mission."""

    model_config = ConfigDict(from_attributes=True)

    mission_id: str
    size_bytes: int
    written_at: float = Field(description="when it was last written to, epoch seconds")


class ReplayBody(BaseModel):
    """What happened during a mission, on the world's clock, in the order it happened."""

    model_config = ConfigDict(from_attributes=True)

    world: dict[str, Any] = Field(
        description="as `GET /v1/worlds/{id}` has it, with its facts, at the beginning"
    )
    goal: dict[str, Any] = Field(description="its last state")
    robots: dict[str, list[list[Any]]] = Field(
        description="by name, rows of at_s, x_m, y_m, heading_rad, what it holds, its packet's tag"
    )
    telemetry: dict[str, list[dict[str, Any]]] = Field(
        description="by name, the other telemetry of the mission's own robots, once a second"
    )
    minds: dict[str, list[dict[str, Any]]] = Field(
        description="by name, what robots with rules believed and were committed to, each from `at_s` on"
    )
    missions: list[dict[str, Any]] = Field(description="the mission's states, each from `at_s` on")
    plans: dict[str, Any] = Field(description="all plans that were made for its goal, by id")
    scripts: dict[str, Any] = Field(description="its robots' scripts, by id")
    samples: list[dict[str, Any]] = Field(description="the samples' believed places, each from `at_s` on")
    numbers: list[dict[str, Any]] = Field(
        description="the world's numeric facts as `values`, each from `at_s` on"
    )
    results: list[dict[str, Any]] = Field(
        description="as `GET /v1/missions/{id}/results` has them; an `image` is a `data:` address"
    )
    events: list[dict[str, Any]] = Field(description="from the submission of its goal on")


def recordings_router(store: RecordingStore, static: Path) -> APIRouter:
    """:param static: the folder of the console's files, which a standalone replay contains."""
    router = APIRouter(prefix="/v1", tags=["recordings"])

    @router.get("/recordings")
    def list_recordings() -> Page[RecordingBody]:
        """The recordings that are kept, the newest first. MACTA_RECORDINGS_MB limits their size."""
        return Page(items=[RecordingBody.model_validate(one) for one in store.recordings()])

    @router.get("/missions/{mission_id}/recording", response_class=McapResponse)
    def get_recording(mission_id: Id) -> McapResponse:
        """The mission's recording so far as one MCAP file. Log times are the world's clock."""
        file = store.merged_file(mission_id)
        headers = {
            "content-length": str(file.seek(0, SEEK_END)),
            "content-disposition": f'attachment; filename="{mission_id}.mcap"',
        }
        return McapResponse(_pieces(file), headers=headers)

    @router.get("/missions/{mission_id}/replay")
    def get_replay(mission_id: Id) -> ReplayBody:
        """The mission's recording in the form that a page replays."""
        return ReplayBody.model_validate(replay_of(store.entries(mission_id)), from_attributes=True)

    @router.get("/missions/{mission_id}/replay.html", response_class=HTMLResponse)
    def get_replay_page(mission_id: Id) -> HTMLResponse:
        """The mission's recording as one standalone HTML file."""
        page = replay_page(static, asdict(replay_of(store.entries(mission_id))), title=f"Macta: {mission_id}")
        # As an attachment: the service's content security policy would block its inline scripts.
        return HTMLResponse(
            page, headers={"content-disposition": f'attachment; filename="{mission_id}.html"'}
        )

    return router


def _pieces(file: IO[bytes]) -> Iterator[bytes]:
    """The file's content from its start; closes the file at its end, or when the client disconnects."""
    with file:
        file.seek(0)
        while piece := file.read(PIECE_BYTES):
            yield piece


def recorded_bodies(worlds: WorldService, plans: PlanApproval) -> RecordedBodies:
    """The functions that return the API's current bodies, for recordings."""

    def facts(name: str) -> list[dict[str, Any]]:
        return [{"predicate": predicate, "args": args} for (predicate, args), _ in worlds.facts(name)[0]]

    def world(name: str) -> dict[str, Any]:
        known = worlds.get(name)
        return {
            "id": known.id,
            "name": known.name,
            "title": known.title,
            "layout": known.layout,
            "facts": facts(name),
        }

    return RecordedBodies(
        goal=lambda row: GoalBody.of(row).model_dump(mode="json"),
        mission=lambda row, scripts: MissionBody.of(row, list(scripts)).model_dump(mode="json"),
        plan=lambda plan_id: plan_body(plans.get(plan_id)).model_dump(mode="json"),
        result=lambda row: ResultBody.model_validate(row).model_dump(mode="json"),
        world=world,
        samples=lambda name: {
            one["args"][0]: one["args"][1] for one in facts(name) if one["predicate"] == "in"
        },
        numbers=lambda name: {row.term: row.value for row in worlds.numbers(name)[0]},
        places=lambda name: {place.name: place.at for place in worlds.world(name).places},
    )
