"""What a robot's synthesis did, tick by tick: every pattern's utilitor, the resultants, and what was driven."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from robots.patterns import Responses
from robots.synthesis import Motion, Utilitor
from robots.wire import TracedPattern, TracedStretch, TracedTick, TraceReport

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

    def report(self, now_s: float, seconds: float) -> TraceReport:
        """What is kept of the last seconds, as it is sent."""
        recent = [instant for instant in self._ring if instant.at_s >= now_s - seconds]
        return TraceReport(
            at_s=now_s, stretches=tuple(_stretch(list(one)) for _, one in groupby(recent, _shape))
        )


def _shape(instant: Instant) -> tuple[str, tuple[TracedPattern, ...], tuple[str, ...]]:
    """What the ticks of one stretch have in common."""
    responses = instant.responses
    patterns = tuple(TracedPattern(name=f"{p.dof}/{p.name}", level=p.level) for p, _ in responses.of)
    return instant.packet_id, patterns, tuple(str(dof) for dof in responses.resultant)


def _stretch(instants: list[Instant]) -> TracedStretch:
    packet_id, patterns, dofs = _shape(instants[0])
    return TracedStretch(
        packet_id=packet_id, patterns=patterns, dofs=dofs, ticks=tuple(_tick(one) for one in instants)
    )


def _tick(instant: Instant) -> TracedTick:
    responses, motion = instant.responses, instant.motion
    return TracedTick(
        at_s=round(instant.at_s, 3),
        patterns=tuple(_rounded(utilitor) for _, utilitor in responses.of),
        resultants=tuple(_rounded(utilitor) for utilitor in responses.resultant.values()),
        linear_m_s=round(motion.linear_m_s, 4),
        angular_rad_s=round(motion.angular_rad_s, 4),
    )


def _rounded(utilitor: Utilitor) -> tuple[float, float]:
    return round(utilitor.response, 4), round(utilitor.u, 4)
