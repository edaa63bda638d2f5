"""The trace of the behaviour synthesis: every pattern's utilitor, the resultants and the velocity, tick by tick."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, groupby
from typing import Any, NamedTuple

from robots.reactive.patterns import BehaviourPattern, Responses
from robots.reactive.synthesis import DegreeOfFreedom, Motion, Utilitor
from robots.wire import TracedCondition, TracedPattern, TracedStretch, TracedTick, TraceReport

KEPT = 1200
"""Ticks: one minute at 20 Hz."""


@dataclass(frozen=True, slots=True)
class Instant:
    """One tick: the patterns' responses, and the body's command after obstacle avoidance."""

    at_s: float
    packet_id: str
    responses: Responses
    motion: Motion


class Shape(NamedTuple):
    """What successive ticks have in common."""

    packet_id: str
    patterns: tuple[BehaviourPattern, ...]
    dofs: tuple[DegreeOfFreedom, ...]


class Trace:
    """A ring buffer of the newest instants, oldest first.

    Each is kept as one flat row of numbers: a minute of 64 robots as objects would be a million of them, which the
    garbage collector would traverse again and again.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._shapes: deque[Shape] = deque(maxlen=kept)
        self._rows: deque[tuple[Any, ...]] = deque(maxlen=kept)

    def record(self, instant: Instant) -> None:
        responses = instant.responses
        motion = instant.motion
        shape = Shape(instant.packet_id, responses.patterns, tuple(responses.resultant))
        # NOTE: successive ticks share one object.
        self._shapes.append(self._shapes[-1] if self._shapes and self._shapes[-1] == shape else shape)
        utilitors = chain.from_iterable((*responses.answers, *responses.resultant.values()))
        self._rows.append(
            (instant.at_s, motion.linear_m_s, motion.angular_rad_s, motion.close_gripper, *utilitors)
        )

    def __iter__(self) -> Iterator[Instant]:
        return (_instant(shape, row) for shape, row in zip(self._shapes, self._rows, strict=True))

    def __len__(self) -> int:
        return len(self._rows)

    def report(
        self, now_s: float, seconds: float, conditions: tuple[TracedCondition, ...] = ()
    ) -> TraceReport:
        """The last seconds as a wire message, with the conditions of the current packet."""
        recent = [instant for instant in self if instant.at_s >= now_s - seconds]
        return TraceReport(
            at_s=now_s,
            stretches=tuple(_stretch(list(one)) for _, one in groupby(recent, _common)),
            conditions=conditions,
        )


def _instant(shape: Shape, row: tuple[Any, ...]) -> Instant:
    at_s, linear_m_s, angular_rad_s, close_gripper, *flat = row
    utilitors = [Utilitor(r, u) for r, u in zip(flat[::2], flat[1::2], strict=True)]
    answers = utilitors[: len(shape.patterns)]
    resultants = utilitors[len(shape.patterns) :]
    responses = Responses(shape.patterns, tuple(answers), dict(zip(shape.dofs, resultants, strict=True)))
    motion = Motion(linear_m_s=linear_m_s, angular_rad_s=angular_rad_s, close_gripper=close_gripper)
    return Instant(at_s, shape.packet_id, responses, motion)


def _common(instant: Instant) -> tuple[str, tuple[TracedPattern, ...], tuple[str, ...]]:
    """What the ticks of one stretch on the wire have in common."""
    responses = instant.responses
    patterns = tuple(TracedPattern(name=f"{p.dof}/{p.name}", level=p.level) for p in responses.patterns)
    return instant.packet_id, patterns, tuple(str(dof) for dof in responses.resultant)


def _stretch(instants: list[Instant]) -> TracedStretch:
    packet_id, patterns, dofs = _common(instants[0])
    return TracedStretch(
        packet_id=packet_id, patterns=patterns, dofs=dofs, ticks=tuple(_tick(one) for one in instants)
    )


def _tick(instant: Instant) -> TracedTick:
    responses = instant.responses
    motion = instant.motion
    return TracedTick(
        at_s=round(instant.at_s, 3),
        patterns=tuple(_rounded(utilitor) for utilitor in responses.answers),
        resultants=tuple(_rounded(utilitor) for utilitor in responses.resultant.values()),
        linear_m_s=round(motion.linear_m_s, 4),
        angular_rad_s=round(motion.angular_rad_s, 4),
    )


def _rounded(utilitor: Utilitor) -> tuple[float, float]:
    return round(utilitor.response, 4), round(utilitor.u, 4)
