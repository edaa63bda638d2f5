"""What a robot's synthesis did, tick by tick: every pattern's utilitor, the resultants, and what was driven."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from robots.patterns import Responses
from robots.synthesis import Motion

KEPT = 1200
"""Ticks kept: the last minute at 20 Hz."""


@dataclass(frozen=True, slots=True)
class Instant:
    """One tick. `motion` is what the body was told, after obstacle avoidance; `responses` what led to it."""

    at_s: float
    packet_id: str
    responses: Responses
    motion: Motion

    def __str__(self) -> str:
        answers = " ".join(f"{name} {r:+.2f}/{u:.2f}" for name, (r, u) in self.responses.shown().items())
        resultants = " ".join(
            f"{dof} {r:+.2f}/{u:.2f}" for dof, (r, u) in self.responses.resultants().items()
        )
        driven = f"{self.motion.linear_m_s:+.2f} m/s {self.motion.angular_rad_s:+.2f} rad/s"
        return f"{self.at_s:.2f} s {self.packet_id}: {answers} => {resultants} => {driven}"


class Trace:
    """A ring of the newest instants, oldest first. Cheap: it keeps what the tick made anyhow, and copies nothing."""

    def __init__(self, kept: int = KEPT) -> None:
        self._ring: deque[Instant] = deque(maxlen=kept)

    def record(self, instant: Instant) -> None:
        self._ring.append(instant)

    def __iter__(self) -> Iterator[Instant]:
        return iter(self._ring)

    def __len__(self) -> int:
        return len(self._ring)

    @property
    def latest(self) -> Instant | None:
        return self._ring[-1] if self._ring else None

    def of(self, packet_id: str) -> list[Instant]:
        """The instants of one packet that are still kept."""
        return [instant for instant in self._ring if instant.packet_id == packet_id]
