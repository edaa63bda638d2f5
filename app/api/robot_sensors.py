"""Routes of the sources of robots' readings: their sensors, or these sensors' virtual counterparts."""

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from app.api.bodies import Page, Request
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.missions.sensor_sources import SensorSource


class SetSource(Request):
    source: SensorSource = Field(
        description="real: the body's own sensor; virtual: the readings that the map's walls would give it"
    )
    comment: str = Field(default="", max_length=2000)


class SensorBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    sensor: str
    source: SensorSource
    edition: int = Field(description="of the robot's world")


def robot_sensors_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.get("/robots/{name}/sensors")
    def list_sensors(services: AppServices, name: Id) -> Page[SensorBody]:
        """The robot's sensors that have a virtual counterpart, and where their readings come from."""
        return Page(items=[SensorBody.model_validate(one) for one in services.sensor_sources.of_robot(name)])

    @router.put("/robots/{name}/sensors/{sensor}", responses=declared(409, 412))
    def set_source(services: AppServices, name: Id, sensor: Id, body: SetSource) -> SensorBody:
        """Replace a simulated robot's sensor by its virtual counterpart, or back, while it works.

        It is an edition of the world (event `world.changed`), which can be undone.
        """
        put = services.sensor_sources.put(name, sensor, body.source, actor=ACTOR, comment=body.comment)
        return SensorBody.model_validate(put)

    return router
