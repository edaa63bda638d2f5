"""The radio between the shared link and one robot: it loses, delays, reorders and repeats, in the world's time.

The fate of a message follows from the seed, the robot, the direction, the world's time and the number of messages
before it, so a resumed world needs no random stream of its radio. Messages under way when the process ends are lost;
the ends of the link repeat them.
"""

import heapq
from collections import Counter
from collections.abc import Sequence
from enum import StrEnum
from hashlib import blake2b

from robots.wire import Message, Telemetry
from robots.world import LinkSpec, WorldFile

MAX_UNDER_WAY = 1000
"""Messages under way in one direction beyond which telemetry, which nobody repeats, is no longer sent."""


class Direction(StrEnum):
    """The way a message goes."""

    UP = "up"
    """From the robot."""
    DOWN = "down"
    """To the robot."""


class Radio:
    """One robot's radio. Times are the world's and do not go back."""

    def __init__(self, link: LinkSpec = LinkSpec(), *, robot: str = "", seed: int = 0) -> None:  # noqa: B008
        self.link = link
        self._name = f"{seed}/{robot}"
        self._under_way: dict[Direction, list[tuple[float, int, Message]]] = {way: [] for way in Direction}
        self._sent: Counter[str] = Counter()
        self._order = 0

    def in_contact(self, at_s: float) -> bool:
        return self.link.in_contact(at_s)

    def send(self, direction: Direction, message: Message, now_s: float) -> None:
        """Send a message now; the radio decides whether and when it arrives."""
        kind = "telemetry" if isinstance(message.body, Telemetry) else "letter"
        if kind == "telemetry" and len(self._under_way[direction]) >= MAX_UNDER_WAY:
            return
        loss, *jitters, duplication = self._draw(f"{direction}/{kind}", now_s)
        if loss < self.link.loss or not self.in_contact(now_s):
            return
        copies = jitters if duplication < self.link.duplication else jitters[:1]
        for jitter in copies:
            arrives_s = now_s + self.link.light_time_s + self.link.delay_s + jitter * self.link.jitter_s
            if self.in_contact(arrives_s):
                self._order += 1
                heapq.heappush(self._under_way[direction], (arrives_s, self._order, message))

    def arrived(self, direction: Direction, now_s: float) -> Sequence[Message]:
        """The messages that have arrived by now, in the order of their arrival."""
        under_way = self._under_way[direction]
        arrived = []
        while under_way and under_way[0][0] <= now_s:
            arrived.append(heapq.heappop(under_way)[2])
        return arrived

    def _draw(self, stream: str, now_s: float) -> tuple[float, ...]:
        """Four numbers in [0, 1). Telemetry has a stream of its own: how much is sent depends on the wall clock."""
        if self.link.is_sure:
            return (0.0, 0.0, 0.0, 0.0)
        self._sent[stream] += 1
        key = f"{self._name}/{stream}/{now_s:.6f}/{self._sent[stream]}"
        digest = blake2b(key.encode(), digest_size=32).digest()
        return tuple(int.from_bytes(digest[at : at + 8], "little") / 2.0**64 for at in range(0, 32, 8))


class PeerRadios:
    """The radio between each two robots, each way with its own random draws."""

    def __init__(self, link: LinkSpec, *, seed: int) -> None:
        self.link = link
        self._seed = seed
        self._radios: dict[tuple[str, str], Radio] = {}

    def send(self, message: Message, now_s: float) -> None:
        pair = message.sender, message.receiver
        if pair not in self._radios:
            self._radios[pair] = Radio(self.link, robot=">".join(pair), seed=self._seed)
        self._radios[pair].send(Direction.UP, message, now_s)

    def arrived(self, now_s: float) -> Sequence[Message]:
        """The messages that have arrived by now."""
        return [message for radio in self._radios.values() for message in radio.arrived(Direction.UP, now_s)]


def peers_of(world: WorldFile, seed: int) -> PeerRadios | None:
    """The radios between the world's robots; None if they do not hear each other."""
    return None if world.peer_link is None else PeerRadios(world.peer_link, seed=seed)


def radios_of(world: WorldFile, seed: int) -> dict[str, Radio]:
    """Every robot's and peripheral's radio, as the world file specifies."""
    names = [*(one.name for one in world.simulated), *(one.name for one in world.simulated_peripherals)]
    return {name: Radio(world.links[name], robot=name, seed=seed) for name in names}
