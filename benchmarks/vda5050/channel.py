"""A connection between master and vehicle that loses, repeats, delays and so reorders messages, with stepped time."""

from collections.abc import Callable
from dataclasses import dataclass, field
from heapq import heappop, heappush
from random import Random


@dataclass(frozen=True, slots=True, kw_only=True)
class Faults:
    """Shares of messages that are lost or repeated, the longest time of one on its way, and how often else fails."""

    lost: float = 0.0
    repeated: float = 0.0
    delay_s: float = 0.0
    restarts_per_s: float = 0.0
    outages_per_s: float = 0.0
    outage_s: float = 20.0


@dataclass
class Channel:
    """One direction. `deliver` is called by `step` with what arrives."""

    random: Random
    faults: Faults
    deliver: Callable[[str, bytes], None]
    is_cut: bool = False
    sent: int = 0
    _now_s: float = 0.0
    _under_way: list[tuple[float, int, str, bytes]] = field(default_factory=list)

    def send(self, address: str, payload: bytes) -> None:
        self.sent += 1
        if self.is_cut or self.random.random() < self.faults.lost:
            return
        copies = 2 if self.random.random() < self.faults.repeated else 1
        for copy in range(copies):
            arrives_s = self._now_s + self.random.random() * self.faults.delay_s
            heappush(self._under_way, (arrives_s, 2 * self.sent + copy, address, payload))

    def step(self, step_s: float) -> None:
        self._now_s += step_s
        while self._under_way and self._under_way[0][0] <= self._now_s:
            _, _, address, payload = heappop(self._under_way)
            self.deliver(address, payload)
