"""The parts of a robot's persistent memory that concern its messages and scripts. All is JSON data."""

from pydantic import Field

from robots.data import Checked, StrEnum
from robots.wire import BehaviourPacket, BehaviourScript, DelegationBid, Message


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


class ConversationMemory(Checked):
    """One side's view of a conversation by the protocol of that name; see `robots.social.conversation`.

    `said_s`, `pause_s`, `has_arrived`: of the last message of this side, which it repeats; `heard`: the ids of the
    partner's messages; `answer`: what the partner has said last, and `answered_s` when.
    """

    protocol: str
    id: str
    partner: str
    is_mine: bool
    state: str
    last_said: Message | None = None
    is_of_rules: bool = False
    speaker: str = ""
    last_heard: str | None = None
    heard: tuple[str, ...] = ()
    said_s: float
    pause_s: float = 0.0
    has_arrived: bool = False
    reply_by_s: float | None = None
    answer: Message | None = None
    answered_s: float = 0.0
    has_ended: bool = False


class BidMemory(Checked):
    """A bid for a leg, by its conversation's key, and its award by the service (`award`, heard at `awarded_s`)."""

    key: str
    leg: str
    busy_s: float
    packets: tuple[BehaviourPacket, ...] = ()
    award: Message | None = None
    awarded_s: float = 0.0
    script_id: str = ""
    until_s: float = 0.0


class PersonsRequestMemory(Checked):
    """What a person has asked for, heard at `at_s`: packets as a script of the robot's own, or a question that waits
    for a reading until `until_s`.
    """

    message: Message
    at_s: float
    script: BehaviourScript | None = None
    until_s: float = 0.0


class SocialMemory(Checked):
    """What a robot has still to say to others, oldest first; other robots' legs that it was awarded, its own leg that
    it puts to others, and the legs that it has withdrawn.

    A mind that is handed over to another program has the conversations, too: those that are open, and the last ones
    that have ended, so that what is repeated is not taken twice; bids, and the scripts of awards that were withdrawn
    (`withdrawn`) and may still arrive; and what persons have asked for.
    """

    owed: tuple[OwedClearance, ...] = ()
    awards: tuple[AwardMemory, ...] = ()
    delegation: DelegationMemory | None = None
    withdrawals: tuple[WithdrawalMemory, ...] = ()
    conversations: tuple[ConversationMemory, ...] = ()
    bids: tuple[BidMemory, ...] = ()
    withdrawn: tuple[str, ...] = ()
    requests: tuple[PersonsRequestMemory, ...] = ()
