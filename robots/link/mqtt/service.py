"""The service's end of a world's link: one client that hears all robots of the world, and follows its fleet."""

import logging
import time
import uuid
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from pydantic import ValidationError

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.following_clock import FollowingClock
from robots.link.mqtt.inbox import Inbox
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Parcel, Session
from robots.link.mqtt.topics import (
    Channel,
    ConnectionState,
    Presence,
    Proclamation,
    channel_of,
    qos_of,
    robot_and_channel,
    robot_topic,
    world_topic,
)
from robots.wire import Message, Telemetry

HEARD = (Channel.STATE, Channel.VISUALIZATION, Channel.CONNECTION)

logger = logging.getLogger(__name__)


class Listener(Protocol):
    """Is told of what is worth something only at once, by the link's own thread."""

    def heard(self, robot: str, telemetry: Telemetry) -> None: ...

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        """:param now: False for what the broker remembers of earlier."""
        ...


class ServiceLink:
    """The agent models' end; implements `robots.link.channel.Link`. `start` before use.

    Messages pass in both directions only for the run of the world that the service has taken up (`take_up`): robots of
    another run stand elsewhere and know of nothing.
    """

    def __init__(
        self,
        world: str,
        robots: Iterable[str],
        broker: Broker,
        *,
        digest: str = "",
        wall_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """:param digest: of the world file; a fleet that drives another is not listened to."""
        self._world, self._names, self._digest = world, frozenset(robots), digest
        self.clock = FollowingClock(wall_s)
        self._inbox = Inbox()
        self._listener: Listener | None = None
        self._proclaimed: str | None = None
        self._taken_up: str | None = None
        self._complaint = ""
        self._session = Session(
            broker,
            f"macta-service-{world}-{uuid.uuid4().hex[:12]}",  # replicas hear the same world
            hears=[
                (world_topic(world), 1),
                *((robot_topic(world, "+", channel), channel.qos) for channel in HEARD),
            ],
            takes=self._take,
        )
        self._reactor = Reactor([self._session], broker=str(broker), wall_s=wall_s)

    def listen(self, listener: Listener) -> None:
        """Have telemetry and connections told; before `start`."""
        self._listener = listener

    def start(self) -> None:
        self._reactor.start()

    @property
    def run(self) -> str | None:
        """The run that the world's fleet last proclaimed, there or not; None before its first word."""
        return self._proclaimed

    @property
    def taken_up(self) -> str | None:
        return self._taken_up

    def take_up(self, run: str) -> None:
        """The record speaks of this run now."""
        self._taken_up = run

    @property
    def connected(self) -> bool:
        return self._session.connected

    @property
    def complaint(self) -> str:
        """Why broker or fleet cannot be dealt with, in words; empty if nothing is known to be wrong."""
        return self._reactor.complaint or self._complaint

    @property
    def malformed(self) -> int:
        return self._inbox.malformed

    @property
    def dropped(self) -> int:
        """Messages lost: the broker was away, or too much waited."""
        return self._session.dropped + self._inbox.dropped

    def send(self, message: Message) -> None:
        """Dropped while the broker is away, or no run of the world is taken up."""
        if self._taken_up is None:
            return
        self._session.publish(
            Parcel(
                topic=robot_topic(self._world, message.receiver, channel_of(message)),
                payload=message.model_dump_json().encode(),
                qos=qos_of(message),
                run=self._taken_up,
            )
        )

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        return self._inbox.take(timeout_s)

    def close(self) -> None:
        self._reactor.close()

    def _take(self, parcel: Parcel) -> None:
        try:
            if parcel.topic == world_topic(self._world):
                self._follow(Proclamation.model_validate_json(parcel.payload), now=not parcel.retain)
                return
            robot, channel = robot_and_channel(parcel.topic) or ("", Channel.STATE)
            if robot in self._names:
                self._sort(robot, channel, parcel)
        except ValidationError as error:
            self._inbox.reject(parcel.topic, error)

    def _sort(self, robot: str, channel: Channel, parcel: Parcel) -> None:
        if channel is Channel.VISUALIZATION:
            telemetry = Telemetry.model_validate_json(parcel.payload)
            if self._listener is not None:
                self._listener.heard(robot, telemetry)
        elif channel is Channel.CONNECTION:
            presence = Presence.model_validate_json(parcel.payload)
            if self._listener is not None:
                self._listener.connected(robot, presence.state, now=not parcel.retain)
        else:
            message = Message.model_validate_json(parcel.payload)
            if message.sender != robot:
                self._inbox.reject(parcel.topic, f"it is from {message.sender}")
            elif parcel.run == self._taken_up:
                self._inbox.put(message)

    def _follow(self, said: Proclamation, *, now: bool) -> None:
        if self._digest and said.digest != self._digest:
            why = f"the fleet of {self._world} drives another world file than the service has; give both the same"
            if why != self._complaint:
                logger.error("%s", why)
            self._complaint = why
            return
        self._complaint = ""
        if said.state is not ConnectionState.ONLINE and said.run == self._proclaimed:
            self.clock.stop()
            return
        goes = now and said.state is ConnectionState.ONLINE
        self.clock.set(said.run, said.time_s, said.rate, goes=goes)
        self._proclaimed = said.run
