"""The domain packs that the service runs with."""

from fastapi import APIRouter

from app.api.bodies import Page
from app.api.services import AppServices
from app.packs.contents import PackContents


def packs_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=["worlds"])

    @router.get("/packs")
    def list_packs(services: AppServices) -> Page[PackContents]:
        """The service's domain packs, each after those that it needs: what robots can do, and where."""
        return Page(items=list(services.packs))

    return router
