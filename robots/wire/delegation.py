"""What a robot tells of a leg that it could not do itself and has put to other robots."""

from typing import Literal

from pydantic import Field

from robots.data import StrEnum
from robots.wire.script import Wire


class DelegationState(StrEnum):
    """What has become of a leg that other robots were called for."""

    AWARDED = "awarded"
    """Another robot does it."""
    DONE = "done"
    """It has done it."""
    FAILED = "failed"
    """It could not do it; others may be called."""
    UNHEARD = "unheard"
    """It has not told its end in time: nobody knows how far it came, so nobody else is called."""
    NOT_TAKEN = "not_taken"
    """No robot took it."""


class DelegationBid(Wire):
    """What a robot has answered to the call. `cost_s`: None if it has made no bid, for the `reason`."""

    robot: str
    cost_s: float | None = Field(default=None, ge=0)
    reason: str = Field(default="", max_length=1024)


class DelegationReport(Wire):
    """Robot to service: a leg of its script is put to other robots, because one of its packets has failed (inform).

    `leg`: its id, as the script names it. `robot`: who was awarded it, empty if nobody was; `bids`: of the last call.
    `expected_s`: what the robot has bid for the way and the work. `stands`: the place near which that robot stands
    since it has done it, `aside` the one that the reporting robot has driven to, to make way; empty if there is none.
    """

    kind: Literal["delegation_report"] = "delegation_report"
    script_id: str
    leg: str
    state: DelegationState
    at_s: float
    robot: str = ""
    bids: tuple[DelegationBid, ...] = Field(default=(), max_length=256)
    expected_s: float = Field(default=0.0, ge=0)
    stands: str = ""
    aside: str = ""
    detail: str = ""
