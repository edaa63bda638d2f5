"""Routes of worlds and their facts."""

from collections.abc import Collection, Mapping, Sequence
from enum import Enum
from typing import Any, Literal

from fastapi import APIRouter, Response

from app.agents.world_service import WorldService
from app.api.bodies import (
    BelievedBody,
    CorrectFacts,
    CorrectNumbers,
    DurationBody,
    FactBody,
    FactsBody,
    NumberBody,
    NumbersBody,
    Page,
    UnknownBody,
    WorldBody,
    WorldItem,
)
from app.api.etags import IfMatch, etag_of, version_of
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.domain.durations import Kind, Learned
from app.domain.world_model.numbers import words_of
from app.domain.world_model.timeliness import DatedFact
from app.store.unknowns import Unknown
from planner import Fact
from robots.wire import SymbolicFact

TAGS: list[str | Enum] = ["worlds and robots"]


def worlds_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/worlds")
    def list_worlds(services: AppServices) -> Page[WorldItem]:
        return Page(
            items=[
                WorldItem.model_validate(world, from_attributes=True) for world in services.worlds.reports()
            ]
        )

    @router.get("/worlds/{world_id}")
    def get_world(services: AppServices, world_id: Id) -> WorldBody:
        return WorldBody.model_validate(services.worlds.get(world_id), from_attributes=True)

    @router.get("/worlds/{world_id}/facts", response_model=FactsBody)
    def get_facts(services: AppServices, world_id: Id) -> Response:
        """Every believed fact with its source and time (world's clock)."""
        version = services.worlds.version(world_id)
        return services.facts_json.answer(world_id, version, lambda: _facts(services.worlds, world_id))

    @router.get("/worlds/{world_id}/numbers", response_model=NumbersBody)
    def get_numbers(services: AppServices, world_id: Id) -> Response:
        """Every numeric fact with its source and time: batteries, loads, numbers of samples, readings."""
        version = services.worlds.numbers_version(world_id)
        return services.numbers_json.answer(world_id, version, lambda: _numbers(services.worlds, world_id))

    @router.put("/worlds/{world_id}/numbers", responses=declared(412))
    def correct_numbers(
        services: AppServices,
        world_id: Id,
        body: CorrectNumbers,
        response: Response,
        if_match: IfMatch = None,
    ) -> NumbersBody:
        """Correct numeric facts, all or none. With `If-Match`, only if they were not changed since (412).

        What is counted from facts follows these and is refused, as is a value out of range.
        """
        services.worlds.correct_numbers(
            world_id,
            [(one.quantity, one.args, one.value) for one in body.numbers],
            actor=ACTOR,
            comment=body.comment,
            expected_version=version_of(if_match),
        )
        answer = _numbers(services.worlds, world_id)
        response.headers["etag"] = etag_of(answer.version)
        return answer

    @router.get("/worlds/{world_id}/unknown")
    def get_unknown(services: AppServices, world_id: Id) -> Page[UnknownBody]:
        """What is unknown: samples without a place, robots that are lost or do not answer."""
        samples = {sample.name for sample in services.worlds.world(world_id).samples}
        return Page(
            items=[_unknown(services.worlds, one, samples) for one in services.worlds.unknown(world_id)]
        )

    @router.get("/worlds/{world_id}/durations")
    def get_durations(services: AppServices, world_id: Id) -> Page[DurationBody]:
        """Durations learned from robots' reports; plans use them."""
        return Page(items=[_duration(*known) for known in services.worlds.durations(world_id).items()])

    @router.put("/worlds/{world_id}/facts", responses=declared(409, 412))
    def correct_facts(
        services: AppServices,
        world_id: Id,
        body: CorrectFacts,
        response: Response,
        if_match: IfMatch = None,
    ) -> FactsBody:
        """Correct the world model. With `If-Match`, only if it was not changed since (412).

        `dropped` in the answer are the facts that contradict the correction. A sample in a location with several berths
        is placed in a free one (409 if there is none).
        """
        dropped = services.worlds.correct(
            world_id,
            [(fact.predicate, fact.args, fact.value) for fact in body.facts],
            actor=ACTOR,
            comment=body.comment,
            expected_version=version_of(if_match),
        )
        answer = _facts(services.worlds, world_id, dropped)
        response.headers["etag"] = etag_of(answer.version)
        return answer

    return router


def _facts(worlds: WorldService, world_id: str, dropped: Sequence[SymbolicFact] = ()) -> FactsBody:
    rows, version = worlds.facts(world_id)
    items = [
        FactBody(
            predicate=predicate,
            args=args,
            source=row.source,
            at_s=row.at_s,
            recorded_at=row.recorded_at,
            instead_of=[_believed(worlds, one) for one in row.instead_of],
        )
        for (predicate, args), row in rows
    ]
    edition = worlds.edition(world_id)
    return FactsBody(items=items, version=version, edition=edition, dropped=list(dropped))


def _numbers(worlds: WorldService, world_id: str) -> NumbersBody:
    rows, version = worlds.numbers(world_id)
    base = worlds.knowledge_base
    items: list[NumberBody] = []
    for row in rows:
        spec = base.quantities.get(row.quantity)
        items.append(
            NumberBody(
                quantity=row.quantity,
                args=tuple(row.args),
                value=row.value,
                unit="" if spec is None else spec.unit,
                text=words_of((row.quantity, tuple(row.args)), row.value, base),
                counted=spec is not None and bool(spec.counts),
                source=row.source,
                at_s=row.at_s,
                recorded_at=row.recorded_at,
                version=row.version,
            )
        )
    return NumbersBody(items=items, version=version)


def _believed(worlds: WorldService, known: Mapping[str, Any]) -> BelievedBody:
    predicate, args = worlds.relation(Fact(known["predicate"], tuple(known["args"])))
    return BelievedBody(predicate=predicate, args=args, source=known["source"], at_s=known["at_s"])


def _unknown(worlds: WorldService, one: Unknown, samples: Collection[str]) -> UnknownBody:
    kind: Literal["sample", "robot"] = "sample" if one.name in samples else "robot"
    return UnknownBody(
        name=one.name,
        kind=kind,
        reason=one.reason,
        since_s=one.since_s,
        last_believed=None if one.last is None else _dated(worlds, one.last),
        earlier_believed=[_dated(worlds, before) for before in one.earlier],
    )


def _dated(worlds: WorldService, known: DatedFact) -> BelievedBody:
    predicate, args = worlds.relation(known.fact)
    return BelievedBody(predicate=predicate, args=args, source=known.source, at_s=known.at_s)


def _duration(kind: Kind, learned: Learned) -> DurationBody:
    return DurationBody(
        action=kind[0],
        robots=kind[1],
        samples=learned.samples,
        mean=round(learned.mean, 3),
        spread=round(learned.spread, 3),
        factor=round(learned.factor, 3),
    )
