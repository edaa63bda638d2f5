"""Routes of robots' factsheets: who has announced itself, and who of them is admitted."""

from fastapi import APIRouter
from pydantic import Field

from app.api.bodies import Decision, FactsheetBody, Page, Request
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from robots.wire import FactsheetState


class RefuseRobot(Request):
    reason: str = Field(min_length=1, max_length=2000, examples=["it belongs to the other hall"])


def factsheets_router() -> APIRouter:
    router = APIRouter(prefix="/v1/worlds/{world_id}", tags=TAGS)

    @router.get("/factsheets")
    def list_factsheets(
        services: AppServices, world_id: Id, state: FactsheetState | None = None
    ) -> Page[FactsheetBody]:
        """The newest factsheet of each robot that has announced itself, with what has become of it.

        Of robots that are in no world those with the state `announced` wait for an operator.
        """
        rows = services.factsheets.of_world(world_id, state)
        return Page(items=[FactsheetBody.model_validate(row) for row in rows])

    @router.post("/robots/{name}:admit", responses=declared(409))
    def admit_robot(
        services: AppServices, world_id: Id, name: Id, body: Decision | None = None
    ) -> FactsheetBody:
        """Add a robot that has announced itself to the world, as it says; checked as any change of the world.

        Of a robot of the world, whose factsheet was refused, the factsheet is followed now.
        """
        comment = body.comment if body else ""
        return FactsheetBody.model_validate(
            services.factsheets.admit(world_id, name, actor=ACTOR, comment=comment)
        )

    @router.post("/robots/{name}:refuse", responses=declared(409))
    def refuse_robot(services: AppServices, world_id: Id, name: Id, body: RefuseRobot) -> FactsheetBody:
        """Refuse a robot that has announced itself. It is told the reason; it may be admitted later."""
        row = services.factsheets.turn_away(world_id, name, actor=ACTOR, reason=body.reason)
        return FactsheetBody.model_validate(row)

    return router
