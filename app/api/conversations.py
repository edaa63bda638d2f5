"""Routes of the service's conversations with robots."""

from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field

from app.api.bodies import Page
from app.api.parameters import Id
from app.api.services import AppServices
from app.api.worlds import TAGS
from robots.wire import Performative


class SaidBody(BaseModel):
    """One message of a conversation."""

    id: str
    sender: str
    receiver: str
    performative: Performative
    content: str = Field(description="a term, such as `bid(leg_1, cost(95))`")
    in_reply_to: str = Field(description="the message that it answers; empty if none")
    sent_at_s: float = Field(description="sender's clock of the world")
    at_s: float = Field(description="when the service has said or heard it, world's clock")


class ConversationBody(BaseModel):
    """A conversation of the service with a robot (FIPA ACL)."""

    model_config = ConfigDict(from_attributes=True)

    id: str
    robot: str
    world: str
    protocol: str
    is_ours: bool = Field(description="the service has opened it")
    state: str = Field(description="of the protocol, or timed_out, not_understood, cancelled")
    is_over: bool
    reason: str = Field(description="why it ended, in the robot's words or the service's")
    about: str = Field(description="the goal, plan or mission that it is about; empty if none")
    speaker: str = Field(description="the person on whose behalf the service speaks; empty if none")
    said: list[SaidBody] = Field(description="oldest first")
    reply_by_s: float | None = Field(description="until when an answer is awaited, world's clock")
    opened_at: str


def conversations_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/robots/{name}/conversations")
    def get_conversations(
        services: AppServices, name: Id, limit: int = Query(default=50, ge=1, le=200)
    ) -> Page[ConversationBody]:
        """The robot's conversations with the service, the newest first. Robots' own are in `mind`, while open."""
        found = services.speech.of_robot(services.robots.robot(name).view.name, limit=limit)
        return Page(items=[ConversationBody.model_validate(one) for one in found])

    return router
