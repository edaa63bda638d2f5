"""Routes of changes of worlds: making and checking them, their history, and undoing them."""

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from app.api.bodies import Page, Request
from app.api.etags import IfMatch, etag_of, version_of
from app.api.goals import ACTOR
from app.api.parameters import Id, Limit
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.domain.world_model.edits import AnyEdit
from app.domain.world_model.vocabulary import symbolic_all
from app.missions.world_changes import CheckedChange
from planner import KnowledgeBase
from robots.wire import SymbolicFact

Before = Annotated[int | None, Query(ge=1, description="`next` of the page before")]
EXAMPLE = [
    {"edit": "add_sample", "sample": {"name": "sample_9", "at": "door_2"}},
    {"edit": "remove_sample", "name": "sample_1"},
    {
        "edit": "add_place",
        "place": {"name": "home_yard_3", "kind": "home", "at": [4, 3], "approach_deg": [-90], "capacity": 0},
    },
    {
        "edit": "add_robot",
        "robot": {"name": "yard_3", "compartment": "yard", "start": [4, 2.2, 90], "home": "home_yard_3"},
    },
    {"edit": "move_place", "name": "bay_3", "at": [0.5, 7.8]},
    {"edit": "remove_place", "name": "bay_12"},
    {"edit": "remove_robot", "name": "yard_2"},
    {
        "edit": "add_zone",
        "zone": {"name": "crossing", "x": [3.4, 4.6], "y": [0, 3.6], "rule": "slow", "max_speed_m_s": 0.2},
    },
    {"edit": "remove_zone", "name": "crossing"},
]


class CheckChange(Request):
    edits: list[AnyEdit] = Field(min_length=1, max_length=1000, examples=[EXAMPLE])
    reason: str = Field(
        default="", max_length=2000, description="so that the body of a change can be checked"
    )


class ChangeWorld(CheckChange):
    """Edits to be made together, in order, or none of them."""

    reason: str = Field(min_length=1, max_length=2000, examples=["a sample was delivered"])


class UndoChange(Request):
    reason: str = Field(default="", max_length=2000)


class EditionBody(BaseModel):
    """An edition of a world: what was changed, by whom and why."""

    model_config = ConfigDict(from_attributes=True)

    edition: int
    edits: list[AnyEdit] = Field(
        description="as they were made; empty if the world was added, or its file replaced"
    )
    actor: str
    reason: str
    at_s: float = Field(description="world's clock")
    made_at: str
    undoes: int | None = Field(description="the edition that this one takes back")
    undone_by: int | None = Field(description="the edition that takes this one back")
    delivery: Literal["pending", "taken_up", "refused"] = Field(
        description="whether the world itself goes on so"
    )
    detail: str = Field(description="why the world refused it")


class CheckedBody(BaseModel):
    """What a change would make of a world."""

    edition: int = Field(description="the number that it would have")
    edits: list[AnyEdit] = Field(description="as they would be made")
    added: list[SymbolicFact]
    removed: list[SymbolicFact]
    outdated_plans: list[str] = Field(description="the open plans that would be out of date")


def world_changes_router() -> APIRouter:
    router = APIRouter(prefix="/v1/worlds/{world_id}", tags=TAGS)

    @router.get("/changes")
    def list_changes(
        services: AppServices, world_id: Id, response: Response, limit: Limit = 100, after: Before = None
    ) -> Page[EditionBody]:
        """The changes since the world's file, newest first. The first page's ETag is the present edition."""
        rows = services.world_changes.history(world_id, limit=limit + 1, before=after)
        if after is None:
            response.headers["etag"] = etag_of(rows[0].edition if rows else 0)
        items = [EditionBody.model_validate(row) for row in rows[:limit]]
        return Page(items=items, next=str(items[-1].edition) if len(rows) > limit else None)

    @router.post("/changes", responses=declared(409, 412))
    def change_world(
        services: AppServices, world_id: Id, body: ChangeWorld, response: Response, if_match: IfMatch = None
    ) -> EditionBody:
        """Change the world while missions run. With `If-Match`, only if it was not changed since that edition (412).

        409 names the mission that needs what would be changed, or the fact in the way. Open plans that rest on what
        has changed are out of date; waiting goals are planned again.
        """
        row = services.world_changes.change(
            world_id,
            body.edits,
            actor=ACTOR,
            source=f"operator {ACTOR}",
            reason=body.reason,
            expected=version_of(if_match),
        )
        response.headers["etag"] = etag_of(row.edition)
        return EditionBody.model_validate(row)

    @router.post("/changes:check", responses=declared(409, 412))
    def check_change(
        services: AppServices, world_id: Id, body: CheckChange, if_match: IfMatch = None
    ) -> CheckedBody:
        """What a change would do, without making it; errors as those of the change."""
        return _checked(
            services.world_changes.check(world_id, body.edits, expected=version_of(if_match)),
            services.worlds.knowledge_base,
        )

    @router.post("/changes/{edition}:undo", responses=declared(409, 412))
    def undo_change(
        services: AppServices,
        world_id: Id,
        edition: int,
        response: Response,
        body: UndoChange | None = None,
        if_match: IfMatch = None,
    ) -> EditionBody:
        """Take a change back by a further one, checked as any other. Undoing that one makes the change again."""
        row = services.world_changes.undo(
            world_id,
            edition,
            actor=ACTOR,
            reason=body.reason if body else "",
            expected=version_of(if_match),
        )
        response.headers["etag"] = etag_of(row.edition)
        return EditionBody.model_validate(row)

    return router


def _checked(checked: CheckedChange, knowledge_base: KnowledgeBase) -> CheckedBody:
    return CheckedBody(
        edition=checked.edition,
        edits=list(checked.edited.made),
        added=list(symbolic_all(sorted(checked.change.add), knowledge_base)),
        removed=list(symbolic_all(sorted(checked.change.remove), knowledge_base)),
        outdated_plans=list(checked.outdated),
    )
