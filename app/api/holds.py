"""Routes of holds: the places of a world that are kept empty, the facts that are kept true, and ending that early."""

from typing import Literal, Self

from fastapi import APIRouter
from pydantic import BaseModel, Field

from app.api.bodies import Decision, Page
from app.api.goals import ACTOR
from app.api.parameters import Id, Limit
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.domain.goal_language.kept_facts import HoldFact
from app.domain.goal_language.stated_holds import HoldEnd, kept_words
from app.domain.kept_record import LostFact
from app.domain.lifecycles.hold import HoldEnding, HoldState
from app.store import HoldRow
from app.store.standing_holds import end_in_words, facts_of

OF_WORDS = ("ends", "words")


class HoldBody(BaseModel):
    """Places of a world that are kept empty and facts that are kept true.

    While the hold stands, no plan puts a sample in the places, nor ends the facts.
    """

    id: str
    world: str
    places: list[str]
    facts: list[HoldFact] = Field(description="what is kept true")
    words: str = Field(description="what it keeps, in words")
    lost: list[LostFact] = Field(description="those of the facts that have ceased to be true")
    until: HoldEnd
    ends: str = Field(description="until when, in words")
    ends_at_s: float | None = Field(description="when its span is over, by the world's clock")
    state: Literal["held", "ended"]
    goal_id: str = Field(description="the goal that stated it; it may have been deleted since")
    text: str = Field(description="what that goal said")
    created_by: str
    created_at: str
    ending: HoldEnding | None = Field(description="why it ended")
    ended_by: str | None = Field(description="the operator who ended it; null if it ended by itself")
    ended_at: str | None
    comment: str

    @classmethod
    def of(cls, row: HoldRow) -> Self:
        known = {name: getattr(row, name) for name in cls.model_fields if name not in OF_WORDS}
        words = {"ends": end_in_words(row), "words": kept_words(row.places, facts_of(row))}
        return cls.model_validate({**known, **words})


def holds_router() -> APIRouter:
    router = APIRouter(prefix="/v1/worlds/{world_id}/holds", tags=TAGS)

    @router.get("")
    def list_holds(
        services: AppServices, world_id: Id, state: HoldState = HoldState.HELD, limit: Limit = 100
    ) -> Page[HoldBody]:
        """The world's holds, newest first: those that stand, or with `state=ended` those that are over."""
        return Page(
            items=[HoldBody.of(row) for row in services.holds.of_world(world_id, state=state, limit=limit)]
        )

    @router.post("/{hold_id}:end")
    def end_hold(services: AppServices, world_id: Id, hold_id: Id, body: Decision | None = None) -> HoldBody:
        """End a hold early; goals that wait for it are planned. Ending it again changes nothing."""
        return HoldBody.of(
            services.holds.end(world_id, hold_id, actor=ACTOR, comment=body.comment if body else "")
        )

    return router
