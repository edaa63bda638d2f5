"""The domain packs that the service runs with."""

from collections.abc import Sequence

from fastapi import APIRouter

from app.api.bodies import Page
from app.packs.contents import PackContents


def packs_router(packs: Sequence[PackContents]) -> APIRouter:
    router = APIRouter(prefix="/v1", tags=["worlds"])

    @router.get("/packs")
    def list_packs() -> Page[PackContents]:
        """The service's domain packs, each after those that it needs: what robots can do, and where."""
        return Page(items=list(packs))

    return router
