"""The robots' end: a client for each robot, with its own last will, and one that proclaims the world."""

import time
from collections.abc import Callable, Iterable, Sequence

from pydantic import ValidationError

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.inbox import Inbox
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Parcel, Session
from robots.link.mqtt.topics import (
    Channel,
    ConnectionState,
    Presence,
    Proclamation,
    channel_of,
    robot_and_channel,
    robot_topic,
    world_topic,
)
from robots.wire import Message, Telemetry

PROCLAIM_S = 1.0
QUEUED_A_ROBOT = 100


class FleetLink:
    """One end for all robots of a world; implements `robots.link.channel.Link`. `start` before use.

    Only what is of this run of the world gets in: an order that was given to the robots of another run, whose place in
    the world is another, is dropped.
    """

    def __init__(
        self,
        world: str,
        robots: Iterable[str],
        broker: Broker,
        *,
        run: str,
        digest: str = "",
        wall_s: Callable[[], float] = time.monotonic,
        epoch_s: Callable[[], float] = time.time,
    ) -> None:
        """
        :param run: the run of the world, see `Proclamation`.
        :param digest: of the world file.
        """
        self._began_at, self._superseded = epoch_s(), False
        self._world, self._run, self._digest, self._wall_s = world, run, digest, wall_s
        self._inbox = Inbox()
        self._rate: float | None = 1.0
        self._time_s, self._proclaimed_s = 0.0, float("-inf")
        self._herald = Session(
            broker,
            f"macta-{world}",
            hears=[(world_topic(world), 1)],
            takes=self._compare,
            will=self._proclamation(ConnectionState.CONNECTION_BROKEN),
            greets=lambda: self._proclamation(ConnectionState.ONLINE),
        )
        self._robots = {robot: self._session(broker, robot) for robot in robots}
        self._reactor = Reactor([self._herald, *self._robots.values()], broker=str(broker), wall_s=wall_s)

    def start(self) -> None:
        self._reactor.start()

    @property
    def connected(self) -> bool:
        """True while the broker has let in every client."""
        return self._herald.connected and all(session.connected for session in self._robots.values())

    @property
    def complaint(self) -> str:
        """Why the broker cannot be entered, in words; empty if nothing is known to be wrong."""
        return self._reactor.complaint

    @property
    def refused(self) -> bool:
        """True if the broker is there but does not let a client in."""
        return self._reactor.refused

    @property
    def superseded(self) -> bool:
        """True if a later fleet drives this world at the broker. This one does not connect any more: close it."""
        return self._superseded

    @property
    def dropped(self) -> int:
        """Messages lost on their way out: the broker was away, or too much waited."""
        return sum(session.dropped for session in self._robots.values())

    @property
    def malformed(self) -> int:
        return self._inbox.malformed

    def proclaim(self, time_s: float, rate: float | None) -> None:
        """Say what the world's time is, at most once a second; to be called as often as one likes."""
        self._time_s, self._rate = time_s, rate
        if self._wall_s() - self._proclaimed_s >= PROCLAIM_S:
            self._proclaimed_s = self._wall_s()
            self._herald.publish(self._proclamation(ConnectionState.ONLINE, qos=0))

    def send(self, message: Message) -> None:
        """In the name of the robot that is its sender. Dropped while the broker is away."""
        channel = channel_of(message)
        content = message.body if isinstance(message.body, Telemetry) else message
        self._robots[message.sender].publish(
            Parcel(
                topic=robot_topic(self._world, message.sender, channel),
                payload=content.model_dump_json(exclude_defaults=content is not message).encode(),
                qos=channel.qos,
                run="" if channel is Channel.VISUALIZATION else self._run,
            )
        )

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        return self._inbox.take(timeout_s)

    def close(self) -> None:
        """Say that robots and world go offline, unless another fleet drives them, and leave."""
        if not self._superseded:
            self._say_offline()
        self._reactor.close()

    def _say_offline(self) -> None:
        for robot, session in self._robots.items():
            session.publish(self._presence(robot, ConnectionState.OFFLINE))
        self._herald.publish(self._proclamation(ConnectionState.OFFLINE))

    def _session(self, broker: Broker, robot: str) -> Session:
        return Session(
            broker,
            f"macta-{self._world}-{robot}",
            hears=[
                (robot_topic(self._world, robot, c), c.qos) for c in (Channel.ORDER, Channel.INSTANT_ACTIONS)
            ],
            will=self._presence(robot, ConnectionState.CONNECTION_BROKEN),
            greets=lambda: self._presence(robot, ConnectionState.ONLINE),
            takes=self._take,
            queued=QUEUED_A_ROBOT,
        )

    def _compare(self, parcel: Parcel) -> None:
        """What is proclaimed of the world: by this fleet, or by another.

        NOTE: two fleets have the same client names, so the broker lets in only the one that came last. They would
        throw each other out for ever.
        """
        try:
            said = Proclamation.model_validate_json(parcel.payload)
        except ValidationError as error:
            self._inbox.reject(parcel.topic, error)
            return
        if said.began_at > self._began_at:
            self._superseded = True
            for session in (self._herald, *self._robots.values()):
                session.retired = True

    def _take(self, parcel: Parcel) -> None:
        try:
            message = Message.model_validate_json(parcel.payload)
        except ValidationError as error:
            self._inbox.reject(parcel.topic, error)
            return
        addressed = robot_and_channel(parcel.topic)
        if addressed is None or addressed[0] != message.receiver:
            self._inbox.reject(parcel.topic, f"it is for {message.receiver}")
        elif parcel.run == self._run:
            self._inbox.put(message)

    def _presence(self, robot: str, state: ConnectionState) -> Parcel:
        topic = robot_topic(self._world, robot, Channel.CONNECTION)
        return Parcel(topic=topic, payload=Presence(state=state).model_dump_json().encode(), retain=True)

    def _proclamation(self, state: ConnectionState, qos: int = 1) -> Parcel:
        said = Proclamation(
            state=state,
            run=self._run,
            time_s=self._time_s,
            rate=self._rate,
            digest=self._digest,
            began_at=self._began_at,
        )
        return Parcel(
            topic=world_topic(self._world), payload=said.model_dump_json().encode(), qos=qos, retain=True
        )
