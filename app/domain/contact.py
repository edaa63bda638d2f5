"""Whether the service is in contact with a robot, as every client sees it (VDA 5050's connection states)."""

from enum import StrEnum


class Connection(StrEnum):
    """A robot's connection."""

    ONLINE = "online"
    """It was heard not long ago."""
    OFFLINE = "offline"
    """It has not been heard for long, or has said that it leaves."""
    HIBERNATING = "hibernating"
    """It has said that it saves energy."""
    CONNECTION_BROKEN = "connection_broken"
    """Its link is closed, or broke without a word."""
