"""The messages by which an operator looks into a robot's synthesis, tick by tick."""

from typing import Literal

from pydantic import Field

from robots.wire.script import Wire

TRACED_S = 60.0
"""A robot keeps about this much of its trace."""

RU = tuple[float, float]


class TraceQuery(Wire):
    """Service to robot: what did the synthesis do in the last seconds (query)?"""

    kind: Literal["trace_query"] = "trace_query"
    seconds: float = Field(gt=0, le=TRACED_S)


class TracedPattern(Wire):
    """A behaviour pattern by name: "dof/name", and its level."""

    name: str
    level: str


class TracedTick(Wire):
    """One tick: normalised (r, u) of each pattern and resultant in the stretch's order, and what was driven.

    What is driven is what obstacle avoidance has left of the resultants.
    """

    at_s: float
    patterns: tuple[RU, ...]
    resultants: tuple[RU, ...]
    linear_m_s: float
    angular_rad_s: float


class TracedStretch(Wire):
    """Successive ticks with the same packet and active patterns. `dofs` are the resultants' degrees of freedom."""

    packet_id: str
    patterns: tuple[TracedPattern, ...]
    dofs: tuple[str, ...]
    ticks: tuple[TracedTick, ...]


class TracedCondition(Wire):
    """A sensor condition of the packet under way: what was perceived at its last tick, in words, after "the robot".

    `when` is before, maintain or after; `holds` is None for what is not sensed now.
    """

    when: str
    words: str
    holds: bool | None = None


class TraceReport(Wire):
    """Robot to service: the answer to a trace query, oldest first (inform).

    Ticks without an active packet are not in it.
    """

    kind: Literal["trace_report"] = "trace_report"
    at_s: float
    stretches: tuple[TracedStretch, ...] = ()
    conditions: tuple[TracedCondition, ...] = ()
