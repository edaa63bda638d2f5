"""The check's end of a broker: a client with the service's rights, which also announces the world."""

import time
from collections import deque
from collections.abc import Sequence

from paho.mqtt.subscribeoptions import SubscribeOptions

from app.cli.trials.conformance.line import RUN
from app.domain.errors import Unavailable
from robots.link.mqtt.broker import Broker
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.topics import (
    ANNOUNCE_INTERVAL_S,
    SERVICE,
    Channel,
    ConnectionState,
    WorldAnnouncement,
    robot_topic,
    world_topic,
)
from robots.wire import CONTRACT

HEARD = (Channel.STATE, Channel.VISUALIZATION, Channel.CONNECTION, Channel.FACTSHEET)
CONNECT_S = 10.0
POLL_S = 0.02


class CheckedBroker:
    """Implements `line.Broker`. The check has a world of its own, so that no service is disturbed."""

    def __init__(self, broker: Broker, world: str, robot: str) -> None:
        """:raises Unavailable: if the broker cannot be reached."""
        self._world = world
        self._began_s = time.monotonic()
        self._announced_s = float("-inf")
        self._arrived: deque[Publication] = deque()
        self._session = Session(
            broker,
            f"macta-check-{time.time_ns()}",
            # With their QoS and retain flag as published: both are judged.
            subscriptions=[
                (robot_topic(world, robot, channel), SubscribeOptions(qos=2, retainAsPublished=True))
                for channel in HEARD
            ],
            on_arrival=self._arrived.append,
        )
        self._reactor = Reactor([self._session], broker=str(broker))
        self._reactor.start()
        while not self._session.connected:
            if self.now_s() > CONNECT_S:
                self._reactor.close()
                raise Unavailable(f"broker {broker} {self._reactor.complaint or 'does not answer'}")
            time.sleep(POLL_S)

    def now_s(self) -> float:
        return time.monotonic() - self._began_s

    def publish(self, publication: Publication) -> None:
        self._session.publish(publication)

    def receive(self, timeout_s: float) -> Sequence[Publication]:
        if self.now_s() - self._announced_s >= ANNOUNCE_INTERVAL_S:
            self._announced_s = self.now_s()
            self._announce()
        end_s = self.now_s() + timeout_s
        while not self._arrived and self.now_s() < end_s:
            time.sleep(POLL_S)
        return [self._arrived.popleft() for _ in range(len(self._arrived))]

    def close(self) -> None:
        """Announce the world as offline, and disconnect."""
        self._announce(ConnectionState.OFFLINE)
        self._reactor.close()

    def _announce(self, state: ConnectionState = ConnectionState.ONLINE) -> None:
        said = WorldAnnouncement(state=state, run=RUN, time_s=self.now_s(), contract=CONTRACT, by=SERVICE)
        payload = said.model_dump_json().encode()
        self.publish(Publication(topic=world_topic(self._world), payload=payload, retain=True))
