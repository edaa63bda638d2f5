"""Whether the service is in contact with a robot, as every client sees it (VDA 5050's connection states)."""

from enum import StrEnum


class Connection(StrEnum):
    """A robot's connection."""

    ONLINE = "online"
    """It was heard recently."""
    OFFLINE = "offline"
    """It has not been heard for long, or has announced that it disconnects."""
    HIBERNATING = "hibernating"
    """It has announced that it saves energy."""
    CONNECTION_BROKEN = "connection_broken"
    """Its link is closed, or broke without an announcement."""
