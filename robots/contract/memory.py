"""The parts of a robot's persistent memory that concern its messages and scripts. All is JSON data."""

from pydantic import Field

from robots.data import Checked, StrEnum
from robots.wire import DelegationBid, Message


class MailboxMemory(Checked):
    """Answers, each with the request that it names, and reports without a receipt; oldest first."""

    answers: tuple[Message, ...] = ()
    reports: tuple[Message, ...] = ()


class StaleMemory(Checked):
    """Scripts cancelled before they arrived, and the newest revision of each mission; oldest first."""

    cancelled: tuple[str, ...] = ()
    revisions: dict[str, int] = Field(default_factory=dict)


class OwedClearance(Checked):
    """A robot that is to be told of an action's end and has not confirmed it. `until_s`: when it no longer waits."""

    robot: str
    script_id: str
    action: str
    until_s: float


class AwardMemory(Checked):
    """A leg of another robot that this one was awarded, by that message, and does by that script of its own.

    `failed`: why that has failed, in words, `ended`: after how many packets, None if that is not known.
    """

    message: Message
    leg: str
    script_id: str
    until_s: float
    failed: str = ""
    ended: int | None = None


class WithdrawalMemory(Checked):
    """A robot that is to stop at a leg and has not confirmed it. `until_s`: when it stops by itself."""

    robot: str
    script_id: str
    until_s: float


class DelegationPhase(StrEnum):
    """How far a robot is that puts a leg to others."""

    PROBING = "probing"
    """It waits whether the service answers, which then decides."""
    MAKING_WAY = "making_way"
    """It drives home."""
    CALLING = "calling"
    """It has called for proposals, or is to call again."""
    AWARDED = "awarded"
    """Another robot does the leg."""


class DelegationMemory(Checked):
    """A leg that is put to others.

    `since_s`: when the phase began; `drives`: how often it has set out to make way; `aside`: the place that it has
    driven to; `tried`: who was awarded it before, or declined the award; `award`: the message by which it was awarded,
    `count` of how many; `bids`: of the last call.
    """

    script_id: str
    leg: str
    phase: DelegationPhase
    since_s: float
    drives: int = 0
    aside: str = ""
    tried: tuple[str, ...] = ()
    award: Message | None = None
    count: int = 0
    expected_s: float = 0.0
    bids: tuple[DelegationBid, ...] = ()


class SocialMemory(Checked):
    """What a robot has still to say to others, oldest first; other robots' legs that it was awarded, its own leg that
    it puts to others, and the legs that it has withdrawn.
    """

    owed: tuple[OwedClearance, ...] = ()
    awards: tuple[AwardMemory, ...] = ()
    delegation: DelegationMemory | None = None
    withdrawals: tuple[WithdrawalMemory, ...] = ()
