"""What is retained at the broker: whether a robot is connected, and which run of a world its fleet drives."""

from enum import StrEnum

from pydantic import Field

from robots.wire.script import Wire


class ConnectionState(StrEnum):
    """VDA 5050's connection states."""

    ONLINE = "online"
    OFFLINE = "offline"
    HIBERNATING = "hibernating"
    CONNECTION_BROKEN = "connection_broken"


class Presence(Wire):
    """On a robot's connection topic. `CONNECTION_BROKEN` is its last will, `OFFLINE` its word of leaving."""

    state: ConnectionState


class Proclamation(Wire):
    """On a world's topic, renewed every second. The last will says `CONNECTION_BROKEN`.

    `run` changes when the world begins afresh; `time_s` is the world's clock, `rate` its seconds a wall-clock second,
    None flat out; `digest` tells world files apart; `began_at` is when the fleet's process began, epoch seconds: of two
    fleets of a world the later one drives it.
    """

    state: ConnectionState
    run: str = Field(min_length=1, max_length=64)
    time_s: float = Field(ge=0)
    rate: float | None = Field(default=1.0, ge=0)
    digest: str = ""
    began_at: float = 0.0
