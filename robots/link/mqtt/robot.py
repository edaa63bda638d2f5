"""The end of robots that do not drive their world: its fleet, or the service, announces run and time."""

import logging
import time
from collections.abc import Callable, Iterable, Mapping

from pydantic import ValidationError

from robots.link.mqtt.broker import Broker
from robots.link.mqtt.following_clock import FollowingClock
from robots.link.mqtt.inbox import Inbox
from robots.link.mqtt.order_check import CounterStore, OrderCheck
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.robot_sessions import (
    RobotsEnd,
    presence,
    put_order,
    quiet_session,
    robot_publication,
    robot_session,
)
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.signature import signers
from robots.link.mqtt.topics import (
    Channel,
    ConnectionState,
    WorldAnnouncement,
    robot_and_channel,
    robot_topic,
    world_topic,
)
from robots.wire import Message

logger = logging.getLogger(__name__)


class RobotLink(RobotsEnd):
    """One end for robots with software of their own; implements `robots.link.channel.Link`. `start` before use.

    Only messages of the announced run pass, in both directions. The robot asks for `run` before each tick: another one
    means that the world was started again and that what it was told before is void.
    """

    def __init__(
        self,
        world: str,
        robots: Iterable[str],
        broker: Broker,
        *,
        keys: Mapping[str, str] | None = None,
        counters: Mapping[str, CounterStore] | None = None,
        stands_by: bool = False,
        wall_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """
        :param robots: those that this process speaks for; each has a client with its own last will.
        :param keys: by robot, `MACTA_ROBOT_KEY` of its enrolment: it signs, and ignores orders that are not signed.
        :param counters: by robot with a key, where the counters of orders are kept over restarts.
        :param stands_by: another program speaks for the robots, until `speak` is called.
        :raises OSError, ValueError: if counters cannot be read.
        """
        self._world = world
        self.clock = FollowingClock(wall_s, extrapolated_s=float("inf"))
        """It runs on in radio silence: what was begun goes on, and its time limits hold."""
        self._run: str | None = None
        self._shown: dict[str, ConnectionState] = {}
        self._inbox = Inbox()
        self._broker = broker
        self._sign = signers(keys or {})
        names = sorted(robots)
        self._quiet = set(names) if stands_by else set[str]()
        self._robots = {robot: self._session(robot) for robot in names}
        self._checks = {
            robot: OrderCheck(key, (counters or {}).get(robot)) for robot, key in (keys or {}).items()
        }
        self._doubted = dict.fromkeys(self._checks, 0)
        if not self._robots:
            raise ValueError("a robot's end of the link needs the name of at least one robot")
        self._world_session = Session(
            broker,
            f"macta-{world}-{'-'.join(names)}-follower"[:200],
            subscriptions=[(world_topic(world), 1)],
            on_arrival=self._follow,
        )
        self._reactor = Reactor(
            [self._world_session, *self._robots.values()], broker=str(broker), wall_s=wall_s
        )

    @property
    def run(self) -> str | None:
        """The run of the world that was last announced; None before the first announcement."""
        return self._run

    @property
    def doubted(self) -> Mapping[str, int]:
        """By robot with a key, the orders that were dropped: not signed, forged, changed, or sent again."""
        return self._doubted

    def send(self, message: Message) -> None:
        """Send as the robot that is the message's sender. Dropped while the broker is unreachable, or without a run."""
        if self._run is not None:
            self._robots[message.sender].publish(robot_publication(self._world, message, self._run))

    def speak(self, robot: str, *, speaks: bool) -> None:
        """Speak for the robot from now on, or leave that to another program and only hear what moves minds."""
        if speaks is (robot not in self._quiet):
            return
        before = self._robots[robot]
        if speaks:
            self._quiet.discard(robot)
        else:
            self._quiet.add(robot)
            before.publish(presence(self._world, robot, ConnectionState.OFFLINE))
            forgotten = robot_topic(self._world, robot, Channel.FACTSHEET)
            before.publish(Publication(topic=forgotten, payload=b"", retain=True))
        session = self._session(robot)
        self._robots = {**self._robots, robot: session}
        self._reactor.add(session)
        self._reactor.remove(before)

    def _session(self, robot: str) -> Session:
        world, broker, sign = self._world, self._broker, self._sign.get(robot)
        if robot in self._quiet:
            return quiet_session(world, robot, broker, self._receive, sign=sign)
        return robot_session(world, robot, broker, self._receive, shown=self._shown, sign=sign)

    def show(self, robot: str, state: ConnectionState) -> None:
        """Show a robot that is itself reached over a further link as connected or not; published if it has changed."""
        if self._shown.get(robot, ConnectionState.ONLINE) is not state:
            self._shown[robot] = state
            self._robots[robot].publish(presence(self._world, robot, state))

    def close(self) -> None:
        """Announce the robots as offline, and disconnect."""
        for robot, session in self._robots.items():
            if robot in self._quiet:
                continue
            session.publish(presence(self._world, robot, ConnectionState.OFFLINE))
        self._reactor.close()

    def _receive(self, publication: Publication) -> None:
        # What robots say to each other is signed with keys that this one does not have.
        robot, _ = robot_and_channel(publication.topic) or ("", None)
        check = self._checks.get(robot)
        if check is not None and (reason := check.doubt(publication)):
            self._doubted[robot] += 1
            if self._doubted[robot] == 1:
                logger.warning(
                    "an order to %s was ignored: %s; later ones are only counted. If it is the service's: give it the"
                    " robot's key (MACTA_ROBOT_KEYS)",
                    robot,
                    reason,
                )
            return
        put_order(publication, self._inbox, self._run)

    def _follow(self, publication: Publication) -> None:
        try:
            announced = WorldAnnouncement.model_validate_json(publication.payload)
        except ValidationError as error:
            self._inbox.reject(publication.topic, error)
            return
        is_online = announced.state is ConnectionState.ONLINE
        if not is_online and announced.run == self._run:
            return
        running = is_online and not publication.retain
        self.clock.set(announced.run, announced.time_s, announced.rate, running=running)
        if announced.run != self._run:
            self._inbox.take(0.0)  # of the run before
            self._run = announced.run
