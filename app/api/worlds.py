"""Worlds and their facts."""

from collections.abc import Sequence
from enum import Enum

from fastapi import APIRouter, Response

from app.api.bodies import (
    CorrectFacts,
    DurationBody,
    FactBody,
    FactsBody,
    Page,
    WorldBody,
    WorldItem,
)
from app.api.goals import ACTOR
from app.api.versions import IfMatch, version_of
from app.durations import Kind, Learned
from app.world_model.desk import WorldDesk
from robots.wire import SymbolicFact

TAGS: list[str | Enum] = ["worlds and robots"]


def worlds_router(worlds: WorldDesk) -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/worlds")
    def list_worlds() -> Page[WorldItem]:
        return Page(
            items=[WorldItem.model_validate(world, from_attributes=True) for world in worlds.reports()]
        )

    @router.get("/worlds/{world_id}")
    def get_world(world_id: str) -> WorldBody:
        return WorldBody.model_validate(worlds.get(world_id), from_attributes=True)

    @router.get("/worlds/{world_id}/facts")
    def get_facts(world_id: str, response: Response) -> FactsBody:
        """Every fact that holds, with who said so and when (world's clock)."""
        return _facts(worlds, world_id, response)

    @router.get("/worlds/{world_id}/durations")
    def get_durations(world_id: str) -> Page[DurationBody]:
        """What robots' reports taught of how long actions take; plans are made with it."""
        return Page(items=[_duration(*known) for known in worlds.durations(world_id).items()])

    @router.put("/worlds/{world_id}/facts")
    def correct_facts(
        world_id: str,
        body: CorrectFacts,
        response: Response,
        if_match: IfMatch = None,
    ) -> FactsBody:
        """Correct the world model. With `If-Match`, only if nobody changed it meanwhile (412).

        The answer's `dropped` are the facts that were believed and cannot hold beside the correction. A sample that is
        laid in a location with several berths lies in a free one (409 if none is).
        """
        dropped = worlds.correct(
            world_id,
            [(fact.predicate, fact.args, fact.value) for fact in body.facts],
            actor=ACTOR,
            comment=body.comment,
            expected_version=version_of(if_match, "the facts"),
        )
        return _facts(worlds, world_id, response, dropped)

    return router


def _facts(
    worlds: WorldDesk, world_id: str, response: Response, dropped: Sequence[SymbolicFact] = ()
) -> FactsBody:
    rows, version = worlds.facts(world_id)
    response.headers["etag"] = f'"{version}"'
    items = [
        FactBody(
            predicate=predicate, args=args, source=row.source, at_s=row.at_s, recorded_at=row.recorded_at
        )
        for (predicate, args), row in rows
    ]
    return FactsBody(items=items, version=version, dropped=list(dropped))


def _duration(kind: Kind, learned: Learned) -> DurationBody:
    return DurationBody(
        action=kind[0],
        robots=kind[1],
        samples=learned.samples,
        mean=round(learned.mean, 3),
        spread=round(learned.spread, 3),
        factor=round(learned.factor, 3),
    )
