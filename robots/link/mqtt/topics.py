"""Which topic a message travels on: `macta/v1/{world}/{robot}/{channel}`, channels after VDA 5050 3.0."""

from enum import StrEnum

from robots.wire import Message, ScriptRequest, SetPoint, Telemetry

ROOT = "macta/v1"
SERVICE = "service"
AT_MOST_ONCE, AT_LEAST_ONCE = 0, 1


class Channel(StrEnum):
    """VDA 5050's topics that we have a use for."""

    ORDER = "order"
    """Scripts."""
    INSTANT_ACTIONS = "instantActions"
    """Everything else to a robot: controls, clearances, queries, tunings, receipts."""
    STATE = "state"
    """Reports and answers of a robot."""
    VISUALIZATION = "visualization"
    """Telemetry."""
    CONNECTION = "connection"
    """Whether the robot is connected; retained, and the last will."""

    @property
    def qos(self) -> int:
        return AT_MOST_ONCE if self is Channel.VISUALIZATION else AT_LEAST_ONCE


def channel_of(message: Message) -> Channel:
    """The channel for a message, by its kind and its receiver."""
    if isinstance(message.body, Telemetry):
        return Channel.VISUALIZATION
    if message.receiver == SERVICE:
        return Channel.STATE
    return Channel.ORDER if isinstance(message.body, ScriptRequest) else Channel.INSTANT_ACTIONS


def qos_of(message: Message) -> int:
    """At most once for what is worth nothing later: a set-point must not wait for its robot at the broker."""
    return AT_MOST_ONCE if isinstance(message.body, SetPoint) else channel_of(message).qos


def robot_topic(world: str, robot: str, channel: Channel) -> str:
    """`robot` may be "+", for all of the world."""
    return f"{ROOT}/{world}/{robot}/{channel}"


def world_topic(world: str) -> str:
    """Where a fleet says which run of the world it drives, and the world's time."""
    return f"{ROOT}/{world}/world"


def robot_and_channel(topic: str) -> tuple[str, Channel] | None:
    """Whose topic it is, and which; None for one that is not a robot's."""
    parts = topic.split("/")
    if len(parts) != 5 or parts[4] not in Channel.__members__.values():
        return None
    return parts[3], Channel(parts[4])
