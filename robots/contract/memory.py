"""The parts of a robot's persistent memory that concern its messages and scripts. All is JSON data."""

from pydantic import Field

from robots.data import Checked
from robots.wire import Message


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


class SocialMemory(Checked):
    """What a robot has still to say to others, oldest first."""

    owed: tuple[OwedClearance, ...] = ()
