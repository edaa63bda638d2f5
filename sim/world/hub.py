"""Routes one shared link's messages to each robot's own link end, through its radio. Telemetry is thinned.

What robots say to each other goes by the radio between them, and not over the shared link, unless the other robot is
not simulated.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from robots.clock import Clock, ManualClock
from robots.contract.mailbox import SERVICE
from robots.link import Link
from robots.wire import WORLD, Message, SpeechAct, Telemetry
from sim.world.radio import Direction, PeerRadios, Radio

MAX_WAITING = 10_000
"""Limit of the messages that wait for room in the channel, or for a snapshot. Beyond it the newest are dropped: robots
repeat what matters."""


class RobotLink:
    """A robot's own end of the shared link; implements `robots.link.channel.Link`. Never blocks."""

    def __init__(self, send: Callable[[Message], None]) -> None:
        self.send = send
        self._arrived: deque[Message] = deque()

    def deliver(self, message: Message) -> None:
        self._arrived.append(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        arrived = tuple(self._arrived)
        self._arrived.clear()
        return arrived

    def close(self) -> None:
        """Nothing to release: the shared link is the hub's."""


class Hub:
    """Connects the shared link with the robots' own ends.

    A world that runs faster than real time makes more telemetry than anybody reads: of each robot's telemetry
    the newest is sent, at most once in `telemetry_gap_s` of the wall clock. Messages that the channel has no room for
    wait here.

    :param has_room: whether the channel can take a message without blocking.
    :param radios: by robot, the radio of its messages both ways; perfect unless given.
    :param holds: nothing but telemetry leaves before `release`.
    """

    def __init__(
        self,
        link: Link,
        robots: Iterable[str],
        *,
        telemetry_gap_s: float = 0.0,
        wall_clock: Clock | None = None,
        has_room: Callable[[], bool] = lambda: True,
        radios: Mapping[str, Radio] | None = None,
        holds: bool = False,
    ) -> None:
        self._link = link
        self._gap_s = telemetry_gap_s
        self._wall_clock = wall_clock or ManualClock()
        self._has_room = has_room
        self._holds = holds
        self._ends: dict[str, RobotLink] = {}
        self._radios: dict[str, Radio] = {}
        self._peers: PeerRadios | None = None
        self._to_peers: list[Message] = []
        self.peer_letters = 0
        """How many messages robots have sent to each other."""
        self.connect({robot: (radios or {}).get(robot) or Radio() for robot in robots})
        self._to_world: deque[Message] = deque()
        self.letters = 0
        """How many messages robots have sent and received, telemetry not counted."""
        self._held: list[Message] = []
        self._outgoing: list[Message] = []
        self._waiting: deque[Message] = deque()
        self._telemetry: dict[str, Message] = {}
        self._telemetry_sent_at_s: dict[str, float] = {}

    def connect(self, radios: Mapping[str, Radio], peers: PeerRadios | None = None) -> None:
        """Serve these robots from now on; those served already keep their ends, and equal radios.

        :param peers: the radios between robots; None: they do not hear each other.
        """
        if peers is None or self._peers is None or self._peers.link != peers.link:
            self._peers = peers
        self._ends = {
            robot: self._ends.get(robot) or RobotLink(partial(self._send, robot)) for robot in radios
        }
        kept = self._radios
        self._radios = {
            robot: kept[robot] if robot in kept and kept[robot].link == radio.link else radio
            for robot, radio in radios.items()
        }

    def link_of(self, robot: str) -> RobotLink:
        return self._ends[robot]

    def to_world(self) -> Sequence[Message]:
        """The messages to the world itself since the last call."""
        arrived = tuple(self._to_world)
        self._to_world.clear()
        return arrived

    def answer(self, message: Message) -> None:
        """Send a message of the world itself; it needs no radio."""
        self._send(WORLD, message)

    @property
    def is_holding(self) -> bool:
        """True while robots have sent something that may not leave yet."""
        return bool(self._held)

    def release(self) -> None:
        """Let what was sent so far leave at the next `flush`."""
        self._outgoing.extend(self._held)
        self._held.clear()

    def receive(self, now_s: float) -> None:
        """Route what has arrived to its receivers; a message to an unknown robot is dropped, as radio would.

        :param now_s: the world's time.
        :raises LinkClosed: if the other end is gone.
        """
        for message in self._link.receive():
            self.letters += 1
            if message.receiver == WORLD:
                self._to_world.append(message)
            elif isinstance(message.body, SpeechAct) and message.sender != SERVICE:
                self._to_peers.append(message)
            elif message.receiver in self._radios:
                self._radios[message.receiver].send(Direction.DOWN, message, now_s)
        for robot, radio in self._radios.items():
            for message in radio.arrived(Direction.DOWN, now_s):
                self._ends[robot].deliver(message)
        self._carry_between_robots(now_s)

    def _carry_between_robots(self, now_s: float) -> None:
        """Transmit what robots have said to each other, and deliver what has arrived."""
        said = self._to_peers
        self._to_peers = []
        if self._peers is None:
            return
        for message in said:
            self._peers.send(message, now_s)
        for message in self._peers.arrived(now_s):
            if message.receiver in self._ends:
                self._ends[message.receiver].deliver(message)
            elif message.sender in self._ends:  # to a robot that is not simulated
                self._leave(message)

    def flush(self, now_s: float) -> None:
        """Transmit the robots' messages and the telemetry that is due; forward what the radio delivers, in order, as
        far as there is room.

        :raises LinkClosed: if the other end is gone.
        """
        outgoing = self._outgoing
        self._outgoing = []
        self._transmit(outgoing, now_s)
        self._transmit(self._due_telemetry(), now_s)

    def _transmit(self, messages: Sequence[Message], now_s: float) -> None:
        for message in messages:
            if message.receiver not in (SERVICE, WORLD):
                self._waiting.append(message)  # it has come over the radio between robots
            elif message.sender in self._radios:
                self._radios[message.sender].send(Direction.UP, message, now_s)
            elif message.sender == WORLD:
                self._waiting.append(message)
        for radio in self._radios.values():
            self._waiting.extend(radio.arrived(Direction.UP, now_s)[: MAX_WAITING - len(self._waiting)])
        while self._waiting and self._has_room():
            self._link.send(self._waiting.popleft())

    def _due_telemetry(self) -> list[Message]:
        """Empty while messages wait for room, or there is no room for it."""
        if not self._telemetry or self._waiting or not self._has_room():
            return []
        now_s = self._wall_clock.now_s()
        last_s = self._telemetry_sent_at_s
        due = [name for name in self._telemetry if now_s - last_s.get(name, -self._gap_s) >= self._gap_s]
        self._telemetry_sent_at_s |= dict.fromkeys(due, now_s)
        return [self._telemetry.pop(robot) for robot in due]

    def _send(self, robot: str, message: Message) -> None:
        """:param robot: who sends it."""
        if isinstance(message.body, Telemetry):
            self._telemetry[message.sender] = message
            return
        if message.receiver not in (SERVICE, WORLD):
            if message.sender == robot and len(self._to_peers) < MAX_WAITING:
                self.peer_letters += 1
                self._to_peers.append(message)
            return
        self.letters += 1
        self._leave(message)

    def _leave(self, message: Message) -> None:
        if not self._holds:
            self._outgoing.append(message)
        elif len(self._held) < MAX_WAITING:
            self._held.append(message)
