"""The robots' end: a client for each robot, with its own last will, and one that announces the world."""

import time
from collections.abc import Callable, Iterable, Mapping

from pydantic import ValidationError

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.inbox import Inbox
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.robot_sessions import RobotsEnd, presence, put_order, robot_publication, robot_session
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.signature import signers
from robots.link.mqtt.topics import (
    ANNOUNCE_INTERVAL_S,
    GREATEST_NUMBER,
    Channel,
    ConnectionState,
    WorldAnnouncement,
    robot_topic,
    world_topic,
)
from robots.wire import CONTRACT, WORLD, Message


class FleetLink(RobotsEnd):
    """One end for all robots of a world; implements `robots.link.channel.Link`. `start` before use.

    Messages of other runs of the world are dropped: they are orders for robots that stand elsewhere.
    """

    def __init__(
        self,
        world: str,
        robots: Iterable[str],
        broker: Broker,
        *,
        run: str,
        digest: str = "",
        packs: Mapping[str, str] | None = None,
        keys: Mapping[str, str] | None = None,
        wall_s: Callable[[], float] = time.monotonic,
        epoch_s: Callable[[], float] = time.time,
    ) -> None:
        """
        :param run: the run of the world, see `WorldAnnouncement`.
        :param digest: of the world file.
        :param packs: the digests of the fleet's domain packs, by name.
        :param keys: with which robots sign what they publish, by robot.
        :param epoch_s: gives a first fleet its number; a wrong clock does no harm.
        """
        self._number = epoch_s()
        self._is_first_heard = True
        self._superseded = False
        self._world = world
        self._run = run
        self._digest = digest
        self._packs = dict(packs or {})
        self._signers = signers(keys or {})
        self._wall_s = wall_s
        self._inbox = Inbox()
        self._rate: float | None = 1.0
        self._time_s = 0.0
        self._announced_s = float("-inf")
        self._world_session = Session(
            broker,
            f"macta-{world}",
            subscriptions=[(world_topic(world), 1)],
            on_arrival=self._compare,
            will=self._announcement(ConnectionState.CONNECTION_BROKEN),
            on_connected=lambda: self._announcement(ConnectionState.ONLINE),
        )
        self._broker = broker
        self._robots = {robot: self._session(broker, robot) for robot in (*robots, WORLD)}
        """The clients of the robots, and one for messages to and from the world itself."""
        self._reactor = Reactor(
            [self._world_session, *self._robots.values()], broker=str(broker), wall_s=wall_s
        )

    def serve(self, robots: Iterable[str]) -> None:
        """Speak for these robots from now on."""
        wanted = {*robots, WORLD}
        gone = {robot: session for robot, session in self._robots.items() if robot not in wanted}
        new = {robot: self._session(self._broker, robot) for robot in wanted - self._robots.keys()}
        kept = {robot: session for robot, session in self._robots.items() if robot in wanted}
        self._robots = {**kept, **new}
        for session in new.values():
            self._reactor.add(session)
        for robot, session in gone.items():
            session.publish(presence(self._world, robot, ConnectionState.OFFLINE))
            forgotten = robot_topic(self._world, robot, Channel.FACTSHEET)
            session.publish(Publication(topic=forgotten, payload=b"", retain=True))
            self._reactor.remove(session)

    @property
    def superseded(self) -> bool:
        """True if a later fleet drives this world. This one does not reconnect: close it."""
        return self._superseded

    @property
    def dropped(self) -> int:
        """Messages lost on sending: the broker was unreachable, or a queue full."""
        return sum(session.dropped for session in self._robots.values())

    def announce(self, time_s: float, rate: float | None) -> None:
        """Publish the world's time and rate, at most once a second however often it is called."""
        self._time_s = time_s
        self._rate = rate
        if self._wall_s() - self._announced_s >= ANNOUNCE_INTERVAL_S:
            self._announced_s = self._wall_s()
            self._world_session.publish(self._announcement(ConnectionState.ONLINE, qos=0))

    def send(self, message: Message) -> None:
        """Send as the robot that is the message's sender. Dropped while the broker is unreachable."""
        if message.sender not in self._robots:
            return  # it was removed, or is about to be served: what matters is repeated
        self._robots[message.sender].publish(robot_publication(self._world, message, self._run))

    def close(self) -> None:
        """Announce robots and world as offline, unless another fleet drives them, and disconnect."""
        if not self._superseded:
            self._announce_offline()
        self._reactor.close()

    def _announce_offline(self) -> None:
        for robot, session in self._robots.items():
            if robot != WORLD:
                session.publish(presence(self._world, robot, ConnectionState.OFFLINE))
        self._world_session.publish(self._announcement(ConnectionState.OFFLINE))

    def _session(self, broker: Broker, robot: str) -> Session:
        return robot_session(
            self._world,
            robot,
            broker,
            self._receive,
            is_robot=robot != WORLD,
            sign=self._signers.get(robot),
        )

    def _compare(self, publication: Publication) -> None:
        """Number this fleet after its predecessor; retire if a successor drives the world.

        The first announcement received is an earlier fleet's, retained by the broker, or this fleet's own. A greater
        number received later belongs to a fleet that began later: this fleet retires, unless the other is offline.

        NOTE: two fleets have the same client names, so the broker disconnects the earlier one. If both reconnected,
        they would disconnect each other for ever.
        """
        try:
            announced = WorldAnnouncement.model_validate_json(publication.payload)
        except ValidationError as error:
            self._inbox.reject(publication.topic, error)
            return
        is_first, self._is_first_heard = self._is_first_heard, False
        if is_first and publication.retain:
            is_greater = announced.began_at >= self._number
        else:
            is_greater = announced.began_at > self._number
        if not is_greater:
            return
        if is_first or announced.state is ConnectionState.OFFLINE:
            self._number = min(announced.began_at + 1, GREATEST_NUMBER)
            self._world_session.set_will(self._announcement(ConnectionState.CONNECTION_BROKEN))
            self._world_session.publish(self._announcement(ConnectionState.ONLINE))
        else:
            self._superseded = True
            for session in (self._world_session, *self._robots.values()):
                session.retired = True

    def _receive(self, publication: Publication) -> None:
        put_order(publication, self._inbox, self._run)

    def _announcement(self, state: ConnectionState, qos: int = 1) -> Publication:
        announcement = WorldAnnouncement(
            state=state,
            run=self._run,
            time_s=self._time_s,
            rate=self._rate,
            digest=self._digest,
            packs=self._packs,
            began_at=self._number,
            contract=CONTRACT,
        )
        return Publication(
            topic=world_topic(self._world),
            payload=announcement.model_dump_json().encode(),
            qos=qos,
            retain=True,
        )
