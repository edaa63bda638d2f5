"""Routes of the bids that robots make for a proposed plan."""

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from app.api.bodies import Page
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.domain.tender_document import OfferBody, TenderBody


class RobotBidBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    state: str = Field(
        description="called, rejected (it has bid, and was told that it was only asked), refused, timed_out, "
        "not_understood, cancelled or no_speech"
    )
    offer: OfferBody | None
    reason: str = Field(description="why it has made no bid; empty if it has, or has not answered yet")


class PartBidsBody(BaseModel):
    """The bids for what one robot does in the plan."""

    model_config = ConfigDict(from_attributes=True)

    robot: str = Field(description="whose part it is in the plan")
    packets: list[str]
    bids: list[RobotBidBody]
    cheapest: str | None = Field(description="the robot whose bid costs least; null while there is none")


def plan_bids_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=["plans"])

    @router.post("/plans/{plan_id}:call_for_bids", status_code=202, responses=declared(409))
    def call_for_bids(services: AppServices, plan_id: Id) -> Page[PartBidsBody]:
        """Ask the robots of the world what each would bid for each robot's part of the proposed plan.

        Answers at once; read the bids with GET. The plan keeps its robots. 409 if it is no longer proposed, or robots
        have not answered the last call yet.
        """
        return Page(
            items=[PartBidsBody.model_validate(one) for one in services.plan_bids.call(plan_id, actor=ACTOR)]
        )

    @router.get("/plans/{plan_id}/bids")
    def get_bids(services: AppServices, plan_id: Id) -> Page[PartBidsBody]:
        """What the robots have answered to the last call; empty if they were not asked."""
        return Page(items=[PartBidsBody.model_validate(one) for one in services.plan_bids.of(plan_id)])

    @router.get("/plans/{plan_id}/tender", responses=declared(409))
    def get_tender(services: AppServices, plan_id: Id) -> TenderBody:
        """Who bid what for the legs of the plan, who is awarded them and why, and what has become of the awards.

        409 if the plan's goal was not put to tender (`allocation`).
        """
        return services.tenders.of_plan(plan_id)

    return router
