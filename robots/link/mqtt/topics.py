"""The topics, `macta/v1/{world}/{robot}/{channel}` with the channels of VDA 5050 3.0, and what is retained on them."""

from pydantic import Field

from robots.data import StrEnum
from robots.wire import Factsheet, ForeignState, Message, ScriptRequest, SetPoint, SpeechAct, Telemetry
from robots.wire.script import Wire

ROOT = "macta/v1"
SERVICE = "service"
FLEET = "fleet"
AT_MOST_ONCE = 0
AT_LEAST_ONCE = 1
ANNOUNCE_INTERVAL_S = 1.0
"""Between two announcements of a world."""
GREATEST_NUMBER = 1e15
"""The greatest number of a fleet: a float to which 1 can still be added."""


class Channel(StrEnum):
    """The topics of VDA 5050 that are used."""

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
    FACTSHEET = "factsheet"
    """What the robot is, retained: a service that starts later reads it."""
    SPEECH = "speech"
    """What the robot says to another; the topic ends with the other's name. VDA 5050 has no such topic."""

    @property
    def qos(self) -> int:
        return AT_MOST_ONCE if self is Channel.VISUALIZATION else AT_LEAST_ONCE


def channel_of(message: Message) -> Channel:
    """The channel for a message, by its kind and its receiver."""
    if isinstance(message.body, Telemetry):
        return Channel.VISUALIZATION
    if isinstance(message.body, Factsheet):
        return Channel.FACTSHEET
    if isinstance(message.body, SpeechAct) and SERVICE not in (message.sender, message.receiver):
        return Channel.SPEECH
    if message.receiver == SERVICE:
        return Channel.STATE
    return Channel.ORDER if isinstance(message.body, ScriptRequest) else Channel.INSTANT_ACTIONS


def qos_of(message: Message) -> int:
    """At most once for set-points, which must not wait for their robot at the broker, and poses for a world."""
    return AT_MOST_ONCE if isinstance(message.body, SetPoint | ForeignState) else channel_of(message).qos


def robot_topic(world: str, robot: str, channel: Channel) -> str:
    """`robot` may be "+", for all of the world."""
    return f"{ROOT}/{world}/{robot}/{channel}"


def speech_topic(world: str, sender: str, receiver: str) -> str:
    """Where one robot speaks to another: only the sender may publish, only the receiver reads. Either may be "+"."""
    return f"{robot_topic(world, sender, Channel.SPEECH)}/{receiver}"


def speakers(topic: str) -> tuple[str, str] | None:
    """Sender and receiver of a topic on which robots speak to each other; None if it is another."""
    parts = topic.split("/")
    return (parts[3], parts[5]) if len(parts) == 6 and parts[4] == Channel.SPEECH else None


def world_topic(world: str) -> str:
    """Where a fleet announces the run of the world that it drives, and the world's time."""
    return f"{ROOT}/{world}/world"


def robot_and_channel(topic: str) -> tuple[str, Channel] | None:
    """Robot and channel of a topic; None if it is not a robot's."""
    parts = topic.split("/")
    if len(parts) != 5 or parts[4] not in Channel.__members__.values():
        return None
    return parts[3], Channel(parts[4])


class ConnectionState(StrEnum):
    """VDA 5050's connection states."""

    ONLINE = "online"
    OFFLINE = "offline"
    HIBERNATING = "hibernating"
    CONNECTION_BROKEN = "connection_broken"


class Presence(Wire):
    """Retained on a robot's connection topic. `CONNECTION_BROKEN` is its last will."""

    state: ConnectionState


class WorldAnnouncement(Wire):
    """Retained on a world's topic, published every second by its fleet, or by the service if it has none.

    `CONNECTION_BROKEN` is a fleet's last will. `run` changes when the world starts again. `time_s`: the world's clock;
    `rate`: world seconds a wall-clock second, None as fast as possible; `contract`: the version of the contract, empty
    if it is not said; `by`: who announces it. `digest`: of the fleet's world file, empty if it is not said; `packs`:
    the digests of the fleet's domain packs, by name; `began_at`: the number of the fleet, greater than that of the
    fleet before it; the service's is the greatest that it has heard. Of two running fleets the one with the greater
    number drives the world. A first fleet takes the epoch seconds at which it began.
    """

    state: ConnectionState
    run: str = Field(min_length=1, max_length=64)
    time_s: float = Field(ge=0)
    rate: float | None = Field(default=1.0, ge=0)
    digest: str = ""
    packs: dict[str, str] = Field(default_factory=dict, max_length=100)
    began_at: float = Field(default=0.0, ge=0, le=GREATEST_NUMBER)
    contract: str = Field(default="", max_length=16)
    by: str = Field(default=FLEET, max_length=16)
