"""Breakpoints on rules: what a robot's rules hold back where a simulated world stops, for people to look at."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from robots.wire import ToldAgent


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldFiring:
    """A rule that has fired and whose commitment is not made yet.

    :param rule: its file and line, "guard:3". :param does: the packet, plan or action; empty: beliefs only.
    :param bindings: the values of the commitment's variables.
    """

    agent: str
    rule: str
    does: str
    bindings: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Halt:
    """Where a robot's mind stands: what is held back, and what its agents believe and are committed to.

    :param at_s: world's clock. :param firings: none after a step in which no breakpoint was met.
    """

    robot: str
    at_s: float
    firings: Sequence[HeldFiring]
    agents: Sequence[ToldAgent]


@dataclass(frozen=True, slots=True, kw_only=True)
class Debugging:
    """The breakpoints of a simulated world, and where it stands.

    :param rules: by robot, "guard:3" and the like. :param halts: where it stands; none: it runs.
    :param left_s: wall-clock seconds until it goes on by itself; None: it runs.
    :param ended: why a stop has ended by itself, in words; empty: none has.
    """

    rules: Mapping[str, frozenset[str]] = field(default_factory=dict)
    halts: Sequence[Halt] = ()
    left_s: float | None = None
    ended: str = ""
