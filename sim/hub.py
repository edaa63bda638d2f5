"""One link of many robots, sorted by receiver to each robot's own end. Telemetry alone is thinned."""

from collections import deque
from collections.abc import Callable, Iterable, Sequence

from robots.link import Link
from robots.wire import Message, Telemetry


class RobotLink:
    """A robot's own end of the shared link; implements `robots.link.Link`. Never blocks."""

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
    waits here.
    """

    def __init__(
        self,
        link: Link,
        robots: Iterable[str],
        *,
        telemetry_gap_s: float = 0.0,
        wall_s: Callable[[], float] = lambda: 0.0,
        has_room: Callable[[], bool] = lambda: True,
    ) -> None:
        self._link, self._gap_s, self._wall_s, self._has_room = link, telemetry_gap_s, wall_s, has_room
        self._ends = {robot: RobotLink(self._take) for robot in robots}
        self._waiting: deque[Message] = deque()
        self._newest: dict[str, Message] = {}
        self._sent_at_s: dict[str, float] = {}

    def end_of(self, robot: str) -> RobotLink:
        return self._ends[robot]

    def fetch(self) -> None:
        """Sort what has arrived to its receivers; a message to nobody here is dropped, as radio would.

        :raises LinkClosed: if the other end is gone.
        """
        for message in self._link.receive():
            if message.receiver in self._ends:
                self._ends[message.receiver].deliver(message)

    def flush(self) -> None:
        """Send what waits, in order, as far as there is room; then the telemetry that is due.

        :raises LinkClosed: if the other end is gone.
        """
        while self._waiting and self._has_room():
            self._link.send(self._waiting.popleft())
        now_s = self._wall_s()
        due = [r for r in self._newest if now_s - self._sent_at_s.get(r, -self._gap_s) >= self._gap_s]
        for robot in due:
            if self._waiting or not self._has_room():
                return
            self._link.send(self._newest.pop(robot))
            self._sent_at_s[robot] = now_s

    def _take(self, message: Message) -> None:
        if isinstance(message.body, Telemetry):
            self._newest[message.sender] = message
        else:
            self._waiting.append(message)
