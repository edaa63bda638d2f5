"""Breakpoints of a world: it stands while a rule is held back at one, until told to go on, or its time is over."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from robots.clock import Clock
from robots.executive.breakpoints import Debugging, Halt

STANDS_AT_MOST_S = 600.0
"""Wall time without a command after which a world goes on by itself, without breakpoints (our choice)."""


class Debugged(Protocol):
    """A simulation whose robots' rules may have breakpoints."""

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None: ...

    def halts(self, robots: frozenset[str] = ...) -> Sequence[Halt]: ...


class Debugger:
    """Says whether the world stands. It sets the breakpoints of its simulation and nobody else does."""

    def __init__(self, simulation: Debugged, wall_clock: Clock) -> None:
        self._simulation = simulation
        self._wall_clock = wall_clock
        self._rules: dict[str, frozenset[str]] = {}
        self._halts: Sequence[Halt] = ()
        self._until_s = 0.0
        self._ended = ""

    @property
    def stands(self) -> bool:
        return bool(self._halts)

    @property
    def left_s(self) -> float | None:
        """Wall seconds until the world goes on by itself; None while it runs."""
        return max(0.0, self._until_s - self._wall_clock.now_s()) if self.stands else None

    def state(self) -> Debugging:
        return Debugging(
            rules=dict(self._rules), halts=tuple(self._halts), left_s=self.left_s, ended=self._ended
        )

    def break_at(self, robot: str, rules: frozenset[str]) -> None:
        """Set the robot's breakpoints; without any in the world, it does not stand."""
        self._ended = ""
        self._rules[robot] = rules
        self._rules = {name: some for name, some in self._rules.items() if some}
        self._simulation.break_at(self._rules)
        if not self._rules:
            self._halts = ()
        self._renew_time()

    def stepped(self) -> bool:
        """To be called after each control cycle of a running world: True if it is to stand."""
        if self._rules:
            self._halt(frozenset())
        return self.stands

    def stand_again(self) -> None:
        """To be called after the one cycle of a step: the world stands, whether a breakpoint was met or not."""
        self._halt(frozenset(one.robot for one in self._halts))

    def go_on(self) -> None:
        self._halts = ()

    def end_if_over(self) -> bool:
        """Remove all breakpoints if nobody has given a command for `STANDS_AT_MOST_S`; True if the world goes on."""
        if not self.stands or self.left_s:
            return False
        self._ended = (
            f"nobody went on for {STANDS_AT_MOST_S:.0f} s: the world runs again, without breakpoints"
        )
        self._rules = {}
        self._simulation.break_at({})
        self._halts = ()
        return True

    def _halt(self, robots: frozenset[str]) -> None:
        self._halts = self._simulation.halts(robots)
        self._renew_time()

    def _renew_time(self) -> None:
        self._until_s = self._wall_clock.now_s() + STANDS_AT_MOST_S
