"""The messages by which an operator drives a robot.

Set-points are worth something only at once: they are never kept or repeated, and a later one takes the place of all
before it. Of two that overtake each other the greater number counts.
"""

from typing import Literal

from pydantic import Field

from robots.wire.script import Wire

VALID_AT_MOST_S = 5.0
"""No set-point moves a robot for longer than this (world's clock)."""


class SetPoint(Wire):
    """Service to robot: drive like this until the next one comes, but no longer than `valid_s` (request).

    `driver` is who drives, from taking the robot until letting go of it; `ends`: the driver lets go.
    """

    kind: Literal["set_point"] = "set_point"
    driver: str = Field(min_length=1, max_length=200)
    number: int = Field(ge=0)
    speed_m_s: float = 0.0
    turn_rad_s: float = 0.0
    valid_s: float = Field(gt=0, le=VALID_AT_MOST_S)
    ends: bool = False


class SetPointRefusal(Wire):
    """Robot to service: why it does not drive by the driver's set-point (refuse). That it does telemetry tells."""

    kind: Literal["set_point_refusal"] = "set_point_refusal"
    driver: str
    reason: str
