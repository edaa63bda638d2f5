"""Routes of the bodies that robots' minds are in, and of moves from one into another."""

from typing import Any, Literal

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from app.api.bodies import Request
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.domain.lifecycles.embodiment import EmbodimentState
from robots.world.bodies import BodyKind, BodySpec


class Embody(Request):
    """The body that the robot's mind is to go on in."""

    body: Literal["real"] | BodySpec = Field(
        description="as in a world file, its kind alone or with its parameters; real: that of the robot's own software",
        examples=["avatar", "real"],
    )
    lease_s: float | None = Field(
        default=None,
        ge=20,
        le=1e6,
        description="how long the robot may act in that body without hearing of the service, in seconds of its world; "
        "then it stands until it does; null: without end",
    )
    comment: str = Field(default="", max_length=2000)


class AttemptBody(BaseModel):
    """A move of the mind into another body."""

    model_config = ConfigDict(from_attributes=True)

    fence: int = Field(description="its fencing number, which counts up")
    state: EmbodimentState
    reason: str = Field(description="why the mind does not get the other body; empty: it does, or may")
    body: dict[str, Any]
    former: dict[str, Any]
    edition: int | None = Field(description="of the world, which exchanges the bodies; null: none was made")
    actor: str
    comment: str
    created_at: str
    ended_at: str | None


class EmbodimentBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    world: str
    kind: BodyKind
    body: dict[str, Any] = Field(description="as in a world file")
    fence: int = Field(description="of the newest move; 0: there was none")
    since: str | None = Field(description="when a move brought the mind there; null: none did")
    lease_s: float | None = Field(
        description="how long it may act without hearing of the service; null: without end"
    )
    lease_until_s: float | None = Field(description="until when it may act now, by the world's clock")
    attempts: list[AttemptBody] = Field(description="moves, newest first")


def embodiments_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/robots/{name}/embodiment")
    def get_embodiment(services: AppServices, name: Id) -> EmbodimentBody:
        """The body that the robot's mind is in, until when it may act there, and its moves."""
        return EmbodimentBody.model_validate(services.embodiments.get(name))

    @router.post("/robots/{name}:embody", status_code=202, responses=declared(409))
    def embody(services: AppServices, name: Id, body: Embody) -> EmbodimentBody:
        """Move the robot's mind into another body, while it works, too; the present body withdraws a move, or changes
        its lease.

        It comes to rest at a safe point, gets the body by an edition of the world, and goes on with its script,
        beliefs, commitments, conversations, tuning and rules (events `embodiment.*`). To the real body and from it, it
        is handed over between the world's simulation and the robot's own software, which must be there.
        """
        wanted = None if body.body == "real" else body.body
        moved = services.embodiments.embody(
            name, wanted, lease_s=body.lease_s, actor=ACTOR, comment=body.comment
        )
        return EmbodimentBody.model_validate(moved)

    return router
