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
