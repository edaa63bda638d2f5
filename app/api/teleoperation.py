"""Teleoperation: short-lived set-points for a robot, and releasing it."""

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict, Field

from app.agents.teleoperation import Drive
from app.api.bodies import Request
from app.api.goals import ACTOR
from app.api.parameters import Id
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS

SESSION = Field(
    min_length=1,
    max_length=64,
    pattern=r"^[A-Za-z0-9_.:-]+$",
    description="chosen by the client, a new one each time it takes control; distinguishes operators",
)


class Release(Request):
    session: str = SESSION


class SetPointRequest(Release):
    """A set-point in the robot's frame; clipped to the limits of a teleoperated robot."""

    speed_m_s: float = Field(default=0.0, ge=-10, le=10, description="ahead; negative: back")
    turn_rad_s: float = Field(default=0.0, ge=-10, le=10, description="to the left; negative: to the right")


class DriveBody(BaseModel):
    model_config = ConfigDict(from_attributes=True)

    robot: str
    driver: str
    driving: bool = Field(description="True if the robot reports that it follows this driver's set-points")
    last_heard_s: float | None = Field(description="seconds ago, wall clock")
    valid_s: float = Field(
        description="world seconds after which the robot stops unless another set-point arrives"
    )
    most_m_s: float
    most_rad_s: float


def teleoperation_router() -> APIRouter:
    router = APIRouter(prefix="/v1", tags=TAGS)

    @router.post("/robots/{name}:teleoperate", status_code=202, responses=declared(409))
    def teleoperate(services: AppServices, name: Id, body: SetPointRequest) -> DriveBody:
        """Drive the robot at this speed until the next set-point, at most for `valid_s`.

        The first set-point takes control; only one operator at a time has it. Send about five set-points a second. The
        robot still avoids obstacles. 409 says why the robot cannot be driven: declared lost, out of contact, on a
        mission, driven by another operator, released in this session, or refused by the robot. After a 409, a
        release, or three seconds without a set-point, control has to be taken again, with a new session.
        """
        drive = services.teleoperation.drive(
            name, _driver(body.session), speed_m_s=body.speed_m_s, turn_rad_s=body.turn_rad_s
        )
        return _body(drive)

    @router.post("/robots/{name}:end_teleoperation", status_code=202, responses=declared(409))
    def end_teleoperation(services: AppServices, name: Id, body: Release) -> DriveBody:
        """Release the robot: it stops at once."""
        return _body(services.teleoperation.release(name, _driver(body.session)))

    return router


def _driver(session: str) -> str:
    return f"{ACTOR} ({session})"


def _body(drive: Drive) -> DriveBody:
    return DriveBody.model_validate(drive)
