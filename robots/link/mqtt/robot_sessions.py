"""A robot's client: what it subscribes to, its presence and last will, and how its messages are published."""

from collections.abc import Callable, Mapping, Sequence

from pydantic import ValidationError

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.inbox import Inbox
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.topics import (
    Channel,
    ConnectionState,
    Presence,
    channel_of,
    robot_and_channel,
    robot_topic,
    speakers,
    speech_topic,
)
from robots.wire import Message, Telemetry

QUEUED_A_ROBOT = 100


def robot_session(
    world: str,
    robot: str,
    broker: Broker,
    on_arrival: Callable[[Publication], None],
    *,
    is_robot: bool = True,
    shown: Mapping[str, ConnectionState] | None = None,
    sign: Callable[[Publication], Publication] | None = None,
) -> Session:
    """
    :param is_robot: False for the world itself, which says by its announcements whether it is there.
    :param shown: by robot, what is published when it is connected, if not that it is online.
    :param sign: signs what the robot publishes; None: nothing is signed.
    """

    def first() -> Publication | None:
        state = (shown or {}).get(robot, ConnectionState.ONLINE)
        return presence(world, robot, state) if is_robot else None

    return Session(
        broker,
        f"macta-{world}-{robot}",
        subscriptions=[
            *((robot_topic(world, robot, c), c.qos) for c in (Channel.ORDER, Channel.INSTANT_ACTIONS)),
            *([(speech_topic(world, "+", robot), Channel.SPEECH.qos)] if is_robot else ()),
        ],
        will=presence(world, robot, ConnectionState.CONNECTION_BROKEN) if is_robot else None,
        on_connected=first,
        on_arrival=on_arrival,
        queued=QUEUED_A_ROBOT,
        sign=sign,
    )


def quiet_session(
    world: str,
    robot: str,
    broker: Broker,
    on_arrival: Callable[[Publication], None],
    *,
    sign: Callable[[Publication], Publication] | None = None,
) -> Session:
    """The client of a robot's own software while another program speaks for the robot: it has a name of its own, or
    the broker would disconnect the other one, no presence and no last will, and hears what moves minds.
    """
    channel = Channel.INSTANT_ACTIONS
    return Session(
        broker,
        f"macta-{world}-{robot}-own",
        subscriptions=[(robot_topic(world, robot, channel), channel.qos)],
        on_arrival=on_arrival,
        queued=QUEUED_A_ROBOT,
        sign=sign,
    )


def presence(world: str, robot: str, state: ConnectionState) -> Publication:
    topic = robot_topic(world, robot, Channel.CONNECTION)
    return Publication(topic=topic, payload=Presence(state=state).model_dump_json().encode(), retain=True)


def robot_publication(world: str, message: Message, run: str) -> Publication:
    """A robot's message, of this run of the world; telemetry goes without the envelope, and is of any run."""
    channel = channel_of(message)
    content = message.body if isinstance(message.body, Telemetry) else message
    return Publication(
        topic=speech_topic(world, message.sender, message.receiver)
        if channel is Channel.SPEECH
        else robot_topic(world, message.sender, channel),
        payload=content.model_dump_json(exclude_defaults=content is not message).encode(),
        qos=channel.qos,
        retain=channel is Channel.FACTSHEET,
        run="" if channel is Channel.VISUALIZATION else run,
    )


def put_order(publication: Publication, inbox: Inbox, run: str | None) -> None:
    """Put a message to a robot into the inbox, if it is one, for the robot that the topic names, and of this run.

    On a topic for speech it must be of the robot that the topic names, which alone may publish there, and be speech.
    """
    try:
        message = Message.model_validate_json(publication.payload)
    except ValidationError as error:
        inbox.reject(publication.topic, error)
        return
    pair = speakers(publication.topic)
    if pair is not None:
        if pair != (message.sender, message.receiver) or channel_of(message) is not Channel.SPEECH:
            inbox.reject(publication.topic, f"it is no speech of {pair[0]} to {pair[1]}")
        elif run is not None and publication.run == run:
            inbox.put(message)
        return
    addressed = robot_and_channel(publication.topic)
    if addressed is None or addressed[0] != message.receiver:
        inbox.reject(publication.topic, f"it is for {message.receiver}")
    elif run is not None and publication.run == run:
        inbox.put(message)


class RobotsEnd:
    """What the ends of robots share: a client for each robot, one that follows the world's topic, and an inbox."""

    _robots: dict[str, Session]
    _world_session: Session
    _reactor: Reactor
    _inbox: Inbox

    def start(self) -> None:
        self._reactor.start()

    @property
    def connected(self) -> bool:
        """True while every client is connected."""
        return self._world_session.connected and all(session.connected for session in self._robots.values())

    @property
    def complaint(self) -> str:
        """Why a client is not connected, in words; empty if no failure is known."""
        return self._reactor.complaint

    @property
    def refused(self) -> bool:
        """True if the broker is reachable but refuses a client."""
        return self._reactor.refused

    @property
    def malformed(self) -> int:
        return self._inbox.malformed

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        return self._inbox.take(timeout_s)
