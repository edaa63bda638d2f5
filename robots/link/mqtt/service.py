"""The service's end of a world's link: one client that receives from all robots of the world and from its fleet."""

import logging
import re
import threading
import time
import uuid
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Protocol

from pydantic import ValidationError

from robots.data import StrEnum
from robots.link.mqtt.broker import Broker
from robots.link.mqtt.following_clock import FollowingClock
from robots.link.mqtt.inbox import Inbox, Rejected
from robots.link.mqtt.reactor import Reactor
from robots.link.mqtt.session import Publication, Session
from robots.link.mqtt.signature import OrderSigner
from robots.link.mqtt.topics import (
    ANNOUNCE_INTERVAL_S,
    SERVICE,
    Channel,
    ConnectionState,
    Presence,
    WorldAnnouncement,
    channel_of,
    qos_of,
    robot_and_channel,
    robot_topic,
    world_topic,
)
from robots.wire import CONTRACT, MAX_FACTSHEET_BYTES, Factsheet, Message, Telemetry, is_same_contract

RECEIVED = (Channel.STATE, Channel.VISUALIZATION, Channel.CONNECTION, Channel.FACTSHEET)
ROBOT_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
MAX_PAYLOAD_BYTES = MAX_FACTSHEET_BYTES + 1024
"""Of a factsheet's message."""
MAX_EARLY = 1000
"""Factsheets that are kept until their run is taken up; more are dropped."""

logger = logging.getLogger(__name__)


class LinkFault(StrEnum):
    """Why no message to or from a world's robots passes, and none will until someone changes that."""

    WORLD_DIFFERS = "world-differs"
    """The fleet drives another world file."""
    CONTRACT_DIFFERS = "contract-differs"
    """The fleet is made for another major version of the contract."""
    BROKER_REFUSES = "broker-refuses"
    """The broker does not let the service in."""


class Listener(Protocol):
    """Receives telemetry and connection states, which are not queued, on the link's own thread."""

    def heard(self, robot: str, telemetry: Telemetry) -> None: ...

    def connected(self, robot: str, state: ConnectionState, *, now: bool) -> None:
        """:param now: False for a retained, earlier state."""
        ...


class Guard(Protocol):
    """Tells robots' messages from those that others publish in their names."""

    def admits(self, robot: str, publication: Publication) -> bool:
        """Whether the message may be the robot's; one that is not is dropped. Called by the link's own thread."""
        ...


class ServiceLink:
    """The agent models' end; implements `robots.link.channel.Link`. `start` before use.

    Only messages of the run of the world that was chosen by `take_up` pass, in both directions: the robots of another
    run stand elsewhere and have other scripts.
    """

    def __init__(
        self,
        world: str,
        robots: Collection[str],
        broker: Broker,
        *,
        digest: str = "",
        wall_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """
        :param robots: the world's; none: only the fleet's announcements are received.
        :param digest: of the world file; a fleet that says it drives another one is ignored.
        """
        self._world = world
        self._digest = digest
        self.clock = FollowingClock(wall_s)
        self._inbox = Inbox()
        self._listener: Listener | None = None
        self._guard: Guard | None = None
        self._orders: OrderSigner | None = None
        self._announced_run: str | None = None
        self._taken_up: str | None = None
        self._wall_s = wall_s
        self._complaint = ""
        self._fault: LinkFault | None = None
        self.announced_by: str | None = None
        """Who announced the run last; None before the first announcement."""
        self._fleet_s = float("-inf")
        """When a fleet was last heard (wall)."""
        self._connected_s = float("inf")
        self._greatest_number = 0.0
        self._announced_s = float("-inf")
        self._early: dict[str, tuple[str, Message]] = {}
        """By robot, a factsheet that came before its run was taken up, with that run."""
        self._taking_up = threading.Lock()
        """Held while a run is taken up or a message compared with it, so that each factsheet is received once."""
        self.packs: Mapping[str, str] = {}
        """The digests of the fleet's domain packs, as it last announced them."""
        self._session = Session(
            broker,
            f"macta-service-{world}-{uuid.uuid4().hex[:12]}",  # replicas receive the same messages
            subscriptions=[
                (world_topic(world), 1),
                *((robot_topic(world, "+", channel), channel.qos) for channel in RECEIVED if robots),
            ],
            on_connected=self._note_connection,
            on_arrival=self._receive,
        )
        self._reactor = Reactor([self._session], broker=str(broker), wall_s=wall_s)

    def listen(self, listener: Listener) -> None:
        """Set who receives telemetry and connection states; before `start`."""
        self._listener = listener

    def guard(self, guard: Guard) -> None:
        """Set who judges messages before they are read; before `start`."""
        self._guard = guard

    def sign_orders(self, signer: OrderSigner) -> None:
        """Set who signs orders to robots that have a key; before `start`."""
        self._orders = signer

    def start(self) -> None:
        self._reactor.start()

    @property
    def run(self) -> str | None:
        """The run that the fleet last announced, connected or not; None before the first announcement."""
        return self._announced_run

    @property
    def taken_up(self) -> str | None:
        return self._taken_up

    def take_up(self, run: str) -> None:
        """Exchange the messages of this run from now on."""
        with self._taking_up:
            self._taken_up = run
            early = [message for its_run, message in self._early.values() if its_run == run]
        for message in early:
            self._inbox.put(message)

    @property
    def connected(self) -> bool:
        return self._session.connected

    @property
    def fault(self) -> LinkFault | None:
        """What keeps all messages from passing; None if nothing is known to. `complaint` is its words."""
        return LinkFault.BROKER_REFUSES if self._reactor.refused else self._fault

    @property
    def is_driven(self) -> bool:
        """True while a fleet announces the world's time."""
        return self.announced_by not in (None, SERVICE) and self.clock.is_running

    @property
    def fleetless_s(self) -> float:
        """Wall-clock seconds, while connected, since a fleet of the world was last heard."""
        return self._wall_s() - max(self._fleet_s, self._connected_s) if self.connected else 0.0

    def announce(self, run: str, time_s: float) -> None:
        """Announce the world in place of a fleet, at most once a second however often it is called."""
        if self._wall_s() - self._announced_s < ANNOUNCE_INTERVAL_S:
            return
        self._announced_s = self._wall_s()
        announcement = WorldAnnouncement(
            state=ConnectionState.ONLINE,
            run=run,
            time_s=time_s,
            began_at=self._greatest_number,
            contract=CONTRACT,
            by=SERVICE,
        )
        payload = announcement.model_dump_json().encode()
        self._session.publish(
            Publication(topic=world_topic(self._world), payload=payload, qos=1, retain=True)
        )

    def _note_connection(self) -> None:
        self._connected_s = self._wall_s()

    @property
    def complaint(self) -> str:
        """What is wrong with broker or fleet, in words; empty if no failure is known."""
        return self._reactor.complaint or self._complaint

    @property
    def malformed(self) -> int:
        return self._inbox.malformed

    @property
    def rejected(self) -> Rejected | None:
        """The invalid messages that were dropped; None: none so far."""
        return self._inbox.rejected

    @property
    def dropped(self) -> int:
        """Messages lost: the broker was unreachable, or a queue full."""
        return self._session.dropped + self._inbox.dropped

    def send(self, message: Message) -> None:
        """Dropped while the broker is unreachable, or no run of the world is taken up."""
        if self._taken_up is None:
            return
        order = Publication(
            topic=robot_topic(self._world, message.receiver, channel_of(message)),
            payload=message.model_dump_json().encode(),
            qos=qos_of(message),
            run=self._taken_up,
        )
        self._session.publish(order if self._orders is None else self._orders.sign(message.receiver, order))

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        return self._inbox.take(timeout_s)

    def close(self) -> None:
        self._reactor.close()

    def _receive(self, publication: Publication) -> None:
        try:
            if publication.topic == world_topic(self._world):
                self._follow(
                    WorldAnnouncement.model_validate_json(publication.payload), now=not publication.retain
                )
                return
            robot, channel = robot_and_channel(publication.topic) or ("", Channel.STATE)
            if robot and (self._guard is None or self._guard.admits(robot, publication)):
                self._dispatch(robot, channel, publication)
        except ValidationError as error:
            self._inbox.reject(publication.topic, error)

    def _dispatch(self, robot: str, channel: Channel, publication: Publication) -> None:
        if channel is Channel.VISUALIZATION:
            telemetry = Telemetry.model_validate_json(publication.payload)
            if self._listener is not None:
                self._listener.heard(robot, telemetry)
        elif channel is Channel.CONNECTION:
            presence = Presence.model_validate_json(publication.payload)
            if self._listener is not None:
                self._listener.connected(robot, presence.state, now=not publication.retain)
        else:
            if channel is Channel.FACTSHEET and not self._may_be_read(robot, publication):
                return
            message = Message.model_validate_json(publication.payload)
            if message.sender != robot:
                self._inbox.reject(publication.topic, f"it is from {message.sender}")
                return
            with self._taking_up:
                if isinstance(message.body, Factsheet) and (
                    robot in self._early or len(self._early) < MAX_EARLY
                ):
                    self._early[robot] = publication.run, message
                is_of_run = publication.run == self._taken_up
            if is_of_run:
                self._inbox.put(message)
            elif not publication.run:
                self._inbox.reject(publication.topic, "it has no user property `run`")

    def _may_be_read(self, robot: str, publication: Publication) -> bool:
        """Whether a factsheet is of a size and sender that one may have; an empty one was taken back."""
        if not publication.payload:
            with self._taking_up:
                self._early.pop(robot, None)
            return False
        if len(publication.payload) > MAX_PAYLOAD_BYTES:
            self._inbox.reject(publication.topic, f"{len(publication.payload)} bytes are too many")
            return False
        if ROBOT_NAME.fullmatch(robot) is None:
            self._inbox.reject(publication.topic, "a robot's name is of small letters, digits and _")
            return False
        return True

    def _follow(self, announced: WorldAnnouncement, *, now: bool) -> None:
        self._greatest_number = max(self._greatest_number, announced.began_at)
        is_online = announced.state is ConnectionState.ONLINE
        if announced.by != SERVICE:
            self._fleet_s = (
                self._wall_s() if announced.state is not ConnectionState.OFFLINE else float("-inf")
            )
            self.packs = announced.packs
        fault = self._fault_of(announced)
        self._note_fault(fault if is_online else None)
        if fault is not None:
            return
        self.announced_by = announced.by
        if not is_online and announced.run == self._announced_run:
            self.clock.stop()
            return
        running = now and is_online
        self.clock.set(announced.run, announced.time_s, announced.rate, running=running)
        self._announced_run = announced.run

    def _fault_of(self, announced: WorldAnnouncement) -> LinkFault | None:
        if not is_same_contract(announced.contract):
            return LinkFault.CONTRACT_DIFFERS
        differs = self._digest and announced.digest and announced.digest != self._digest
        return LinkFault.WORLD_DIFFERS if differs else None

    def _note_fault(self, fault: LinkFault | None) -> None:
        words = {
            None: "",
            LinkFault.WORLD_DIFFERS: f"the fleet of {self._world} drives another world file than the service has;"
            " give both the same",
            LinkFault.CONTRACT_DIFFERS: f"{self._world} is announced by another major version of the contract than"
            f" {CONTRACT}; give service and fleet the same version of Macta",
        }[fault]
        if words and words != self._complaint:
            logger.error("%s", words)
        self._fault = fault
        self._complaint = words
