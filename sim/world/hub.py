"""One link of many robots, sorted by receiver to each robot's own end, through its radio. Telemetry is thinned."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence

from robots.link import Link
from robots.wire import Message, Telemetry
from sim.world.radio import Radio, Way

WAITING_AT_MOST = 10_000
"""Letters that wait for room in the channel, or for a disk that takes no snapshots. Of more the newest are dropped:
robots keep what matters."""


class RobotLink:
    """A robot's own end of the shared link; implements `robots.link.channel.Link`. Never blocks."""

    def __init__(self, send: Callable[[Message], None]) -> None:
        self._send = send
        self._arrived: deque[Message] = deque()

    def deliver(self, message: Message) -> None:
        self._arrived.append(message)

    def send(self, message: Message) -> None:
        self._send(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        arrived = tuple(self._arrived)
        self._arrived.clear()
        return arrived

    def close(self) -> None:
        """Nothing to release: the shared link is the hub's."""


class Hub:
    """Stands between the shared link and the robots.

    A world that runs faster than real time makes more telemetry than anybody reads: of each robot's telemetry
    the newest is sent, at most once in `telemetry_gap_s` of the wall clock. What the channel has no room for
    waits here. With `holds`, nothing but telemetry leaves before `release`.

    :param radios: by robot, what its messages pass through both ways; perfect unless given.
    """

    def __init__(
        self,
        link: Link,
        robots: Iterable[str],
        *,
        telemetry_gap_s: float = 0.0,
        wall_s: Callable[[], float] = lambda: 0.0,
        has_room: Callable[[], bool] = lambda: True,
        radios: Mapping[str, Radio] | None = None,
        holds: bool = False,
    ) -> None:
        self._link, self._gap_s, self._wall_s, self._has_room = link, telemetry_gap_s, wall_s, has_room
        self._ends = {robot: RobotLink(self._take) for robot in robots}
        self._radios = {robot: (radios or {}).get(robot) or Radio() for robot in self._ends}
        self._letters: list[Message] = []
        self._waiting: deque[Message] = deque()
        self._holds = holds
        self._held: list[Message] = []
        self._newest: dict[str, Message] = {}
        self._sent_at_s: dict[str, float] = {}

    def end_of(self, robot: str) -> RobotLink:
        return self._ends[robot]

    @property
    def holding(self) -> bool:
        """True while robots have said something that may not leave yet."""
        return bool(self._held)

    def release(self) -> None:
        """What was said so far may leave when the hub is flushed."""
        self._letters.extend(self._held)
        self._held.clear()

    def fetch(self, now_s: float) -> None:
        """Sort what has arrived to its receivers; a message to nobody here is dropped, as radio would.

        :param now_s: the world's time.
        :raises LinkClosed: if the other end is gone.
        """
        for message in self._link.receive():
            if message.receiver in self._radios:
                self._radios[message.receiver].send(Way.DOWN, message, now_s)
        for robot, radio in self._radios.items():
            for message in radio.arrived(Way.DOWN, now_s):
                self._ends[robot].deliver(message)

    def flush(self, now_s: float) -> None:
        """Let the robots' letters leave, and the telemetry that is due; hand on what has come through, in order, as far
        as there is room.

        :raises LinkClosed: if the other end is gone.
        """
        letters, self._letters = self._letters, []
        self._transmit(letters, now_s)
        self._transmit(self._due_telemetry(), now_s)

    def _transmit(self, messages: Sequence[Message], now_s: float) -> None:
        for message in messages:
            self._radios[message.sender].send(Way.UP, message, now_s)
        for radio in self._radios.values():
            self._waiting.extend(radio.arrived(Way.UP, now_s)[: WAITING_AT_MOST - len(self._waiting)])
        while self._waiting and self._has_room():
            self._link.send(self._waiting.popleft())

    def _due_telemetry(self) -> list[Message]:
        """None while letters wait for room, or there is none for it."""
        if not self._newest or self._waiting or not self._has_room():
            return []
        now_s = self._wall_s()
        due = [r for r in self._newest if now_s - self._sent_at_s.get(r, -self._gap_s) >= self._gap_s]
        self._sent_at_s |= dict.fromkeys(due, now_s)
        return [self._newest.pop(robot) for robot in due]

    def _take(self, message: Message) -> None:
        if isinstance(message.body, Telemetry):
            self._newest[message.sender] = message
        elif self._holds:
            if len(self._held) < WAITING_AT_MOST:
                self._held.append(message)
        else:
            self._letters.append(message)
