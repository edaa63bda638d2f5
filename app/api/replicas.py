"""The processes that share the record: which live, and what each does."""

from collections.abc import Sequence

from fastapi import APIRouter
from pydantic import BaseModel

from app.api.bodies import Page
from app.workflows.leases import ExecutorRegistry


class ExecutorBody(BaseModel):
    """A process: `serves` are the queues whose work it does, `worlds` those whose robots it speaks to."""

    id: str
    serves: Sequence[str]
    worlds: Sequence[str]
    host: str
    pid: int
    started_at: str
    seen_s: float
    alive: bool


def replicas_router(presence: ExecutorRegistry) -> APIRouter:
    router = APIRouter(prefix="/v1", tags=["health"])

    @router.get("/executors")
    def list_executors() -> Page[ExecutorBody]:
        """The service's processes on this database, the longest there first; dead ones for a minute."""
        items = [ExecutorBody.model_validate(one, from_attributes=True) for one in presence.executors()]
        return Page(items=items)

    return router
