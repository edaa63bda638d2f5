"""The messages by which the service has a robot's mind rest, and go on, in one of the robot's bodies."""

from typing import Literal

from pydantic import Field

from robots.data import StrEnum
from robots.wire.script import Wire


class MindVerb(StrEnum):
    """What a robot's mind is to do."""

    REST = "rest"
    """Stand still at a safe point, and do nothing until it is told to go on."""
    GO_ON = "go_on"
    """Go on from there."""


class MindOrder(Wire):
    """Service to robot: let your mind rest before it gets another body, or go on (request).

    `fence`: the fencing number; one lower than that of an order followed before is refused. `within_s`: a mind that
    has not come to rest in this time refuses. `lease_until_s`: of a mind that goes on, until when, by the world's
    clock: then it rests by itself, unless it is told a later time under the same number; None: without end.
    """

    kind: Literal["mind_order"] = "mind_order"
    verb: MindVerb
    fence: int = Field(ge=1)
    within_s: float = Field(default=30.0, gt=0)
    lease_until_s: float | None = None


class MindOrderReport(Wire):
    """Robot to service: the mind rests, or goes on (agree), or does not for a reason (refuse).

    `lease_until_s`: of a mind that goes on, until when, as it was told.
    """

    kind: Literal["mind_order_report"] = "mind_order_report"
    verb: MindVerb
    fence: int
    reason: str = ""
    lease_until_s: float | None = None
