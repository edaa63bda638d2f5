"""The processes that share the database."""

from collections.abc import Mapping, Sequence

from fastapi import APIRouter
from pydantic import BaseModel, Field

from app.api.bodies import Page
from app.api.services import AppServices
from app.planning.pool.status import PoolStatus


class ExecutorBody(BaseModel):
    """A process: `serves` are the queues it works on, `worlds` those whose robots it drives.

    `planning` is what its planning processes do, and the work that waits for them: now for the process that answers,
    at their last heartbeat for others.
    """

    id: str
    serves: Sequence[str]
    worlds: Sequence[str]
    host: str
    pid: int
    started_at: str
    seen_s: float
    alive: bool
    planning: PoolStatus | None = None
    packs: Mapping[str, str] | None = Field(
        default=None, description="the digests of its domain packs, by name"
    )


def executors_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=["health"])

    @router.get("/executors")
    def list_executors(services: AppServices) -> Page[ExecutorBody]:
        """The service's processes on this database, the oldest first; ended ones are listed for a minute."""
        items = [
            ExecutorBody.model_validate(one, from_attributes=True) for one in services.executors.executors()
        ]
        return Page(items=items)

    return router
