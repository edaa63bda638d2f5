"""Stimuli of the kick: to get behind a ball, seen from where it is to roll, and to drive through it (our choice).

In the ball's frame the x axis points to where it is to roll. A robot within a cone about the negative x axis is lined
up and drives along the axis; any other drives to a point behind the ball, round the ball if that is in the way.
"""

from cmath import exp, phase
from dataclasses import dataclass
from math import cos, pi
from typing import Annotated

from pydantic import Field

from robots.perception.percepts import TRACKING, Percepts
from robots.physical.geometry import clip, to_robot
from robots.reactive.stimuli import Stimulus

BEHIND_M = 0.7
"""How far behind the ball a robot begins to drive through it."""
ROUND_M = 0.6
"""How far beside the ball it goes round it."""
CLEAR_M = 0.42
"""A way that leads nearer past the ball than this might touch it."""
CONE = 0.35
"""Of a robot that is lined up: metres to the side for each metre behind."""
LOOK_AHEAD_M = 0.5
"""How far ahead on the line it aims."""
LEAD_S = 0.5
"""How far ahead in time the place of a rolling ball is taken."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Where to drive, in the robot's frame, and whether the robot is lined up."""

    aim: complex
    is_lined_up: bool


def approach(ball: complex, to: complex) -> Approach:
    """The way of a robot that wants the ball to roll to a point; both in the robot's frame, metres."""
    push = (to - ball) / (abs(to - ball) or 1.0)
    at = -ball / push
    if at.real < 0 and abs(at.imag) <= 0.05 - CONE * at.real:
        return Approach(ball + push * min(at.real + LOOK_AHEAD_M, 0.3), True)
    behind = complex(-BEHIND_M)
    if _passes_m(at, behind) < CLEAR_M:
        side = 1 if at.imag >= 0 else -1
        return Approach(ball + push * complex(-0.1, side * ROUND_M), False)
    return Approach(ball + push * behind, False)


def _passes_m(start: complex, end: complex) -> float:
    """The least distance of a segment from the origin."""
    along = end - start
    share = clip(-(start * along.conjugate()).real / (abs(along) ** 2 or 1.0), 0.0)
    return abs(start + share * along)


def _read(percepts: Percepts, ball: str, to: complex) -> Approach | None:
    is_tracked = percepts.evidence(ball) > 0
    at = percepts.locate(ball)
    if at is None:
        return None
    if is_tracked and (cursor := percepts.cursors[ball]).moving_at(percepts.time_s):
        at += LEAD_S * cursor.velocity * exp(-1j * percepts.pose.heading_rad)
    return approach(at, to_robot(percepts.pose, to))


class KickTurn(Stimulus, needs=TRACKING):
    """The direction of the way to kick a ball to a point of the world's frame; 1 at `full_rad` to the left."""

    object: str
    x_m: float
    y_m: float
    full_rad: Annotated[float, Field(gt=0, le=pi)] = 0.8

    def read(self, percepts: Percepts) -> float | None:
        way = _read(percepts, self.object, complex(self.x_m, self.y_m))
        return None if way is None else clip(phase(way.aim) / self.full_rad)


class KickPace(Stimulus, needs=TRACKING):
    """1 while the robot is lined up to kick a ball to a point of the world's frame, `slower` on the way there.

    Off to the side it shrinks with the bearing's cosine, so that the robot turns first.
    """

    object: str
    x_m: float
    y_m: float
    slower: Annotated[float, Field(gt=0, le=1)] = 0.7

    def read(self, percepts: Percepts) -> float | None:
        way = _read(percepts, self.object, complex(self.x_m, self.y_m))
        if way is None:
            return None
        return (1.0 if way.is_lined_up else self.slower) * max(0.0, cos(phase(way.aim)))
