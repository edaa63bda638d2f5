"""Whether the robot's mind may act in this body: under the newest fencing number, and until its lease ends.

A mind that is to get another body comes to rest first, at a safe point (SRA, Virtual Robotic Workbench: migration of
agents among robotic platforms). The service alone lets it go on, so that it never acts in two bodies.
"""

from typing import NamedTuple

from pydantic import Field

from robots.data import Checked
from robots.physical.body import Pose
from robots.wire import Message, MindOrder, MindOrderReport, MindVerb, Performative

STEP_M = 0.002
STEP_RAD = 0.005
"""A robot whose odometry moves less than this in a tick stands (our choice: 0.04 m/s and 0.1 rad/s)."""


class EmbodimentMemory(Checked):
    """The newest fencing number, whether the mind rests, and the end of its lease; None: without end.

    `is_handed_over`: another program has the mind, or may get it: this one neither acts nor speaks.
    """

    fence: int = Field(default=0, ge=0)
    rests: bool = False
    is_handed_over: bool = False
    lease_until_s: float | None = None


class Answer(NamedTuple):
    """What is answered to an order."""

    request: Message
    performative: Performative
    report: MindOrderReport
    piece: int | None = None
    """Of the mind's document, to be sent with it."""


class Embodiment:
    """One robot's. Times are the world's clock."""

    def __init__(self) -> None:
        self._state = EmbodimentMemory()
        self._asked: tuple[Message, MindOrder, float] | None = None
        self._stands_by = False
        self._last: Pose | None = None

    def memory(self) -> EmbodimentMemory:
        """A mind that was asked to rest, and has not answered, is asked again."""
        return self._state

    def recall(self, memory: EmbodimentMemory) -> None:
        self._state = memory

    @property
    def is_mute(self) -> bool:
        """True while another program speaks for the robot, or may."""
        return self._state.is_handed_over

    @property
    def is_to_be_handed_over(self) -> bool:
        """True while it is asked to rest for that."""
        return self._asked is not None and self._asked[1].piece is not None

    @property
    def fence(self) -> int:
        return self._state.fence

    @property
    def rests(self) -> bool:
        return self._state.rests

    def stands(self, now_s: float) -> bool:
        """True while the robot is to stand still: its mind rests, is about to, or has no lease."""
        lease_s = self._state.lease_until_s
        return self._state.rests or self._stands_by or (lease_s is not None and now_s > lease_s)

    def follow(self, request: Message, order: MindOrder, now_s: float) -> Answer | None:
        """Follow an order; None if it is answered later, by `settle`."""
        state = self._state
        goes_on = order.verb is MindVerb.GO_ON
        if order.fence < state.fence or (order.fence == state.fence and not (goes_on or state.rests)):
            return _answer(request, order, f"fencing number {order.fence} is over, {state.fence} is in force")
        if not goes_on and order.fence > state.fence:
            self._asked = (request, order, now_s + order.within_s)
            return None
        if goes_on:
            if state.is_handed_over and order.fence > state.fence:
                return _answer(request, order, f"no mind was handed over under fencing number {order.fence}")
            self._asked = None
            self._stands_by = False
            self._state = EmbodimentMemory(fence=order.fence, lease_until_s=order.lease_until_s)
        elif order.piece is not None:
            self._state = state.model_copy(update={"is_handed_over": True})
        return _answer(request, order)

    def settle(self, odometry: Pose | None, now_s: float, *, unsafe: str) -> Answer | None:
        """Come to rest if that was asked for; the answer once it rests, or cannot in time.

        :param odometry: None during a sensor fault. :param unsafe: why this is no safe point; empty if it is one.
        """
        last = self._last
        self._last = odometry
        if self._asked is None:
            return None
        request, order, until_s = self._asked
        is_still = last is not None and odometry is not None and _is_near(last, odometry)
        if self._stands_by and is_still and not unsafe:
            is_handed_over = order.piece is not None
            self._state = EmbodimentMemory(fence=order.fence, rests=True, is_handed_over=is_handed_over)
            answer = _answer(request, order)
        elif now_s > until_s:
            answer = _answer(request, order, f"it has come to no safe point in time: {unsafe or 'it moves'}")
        else:
            self._stands_by = not unsafe
            return None
        self._asked = None
        self._stands_by = False
        return answer


def _answer(request: Message, order: MindOrder, reason: str = "") -> Answer:
    report = MindOrderReport(
        verb=order.verb, fence=order.fence, reason=reason, lease_until_s=order.lease_until_s
    )
    if reason:
        return Answer(request, Performative.REFUSE, report)
    return Answer(request, Performative.AGREE, report, order.piece)


def _is_near(one: Pose, other: Pose) -> bool:
    return (
        abs(one.x_m - other.x_m) < STEP_M
        and abs(one.y_m - other.y_m) < STEP_M
        and abs(one.heading_rad - other.heading_rad) < STEP_RAD
    )
