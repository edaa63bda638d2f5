"""The mechanisms of simulated doors, hatches and lifts: panels that rise and sink, and what may befall them.

A panel takes `opening_s` to rise and `closing_s` to sink. It does not sink on a rover or sample: it rises again and
says what is in its way. Of a lift, the doors close, the cabin is on its way for `travel_s`, and the door of the other
level opens; in the plane the cabin stays where it is.
"""

from enum import StrEnum

from robots.adapters.peripheral import CLOSED, OPEN
from robots.world import Peripheral
from robots.world.walls import Panel
from sim.physics.scene import Scene
from sim.snapshot import PeripheralState

BLOCKED_S = 8.0
"""How long a closing door waits for what is in its way before it reports that."""
SHUT_S = 3.0
"""How long a door that shuts whatever its script says is shut before it reports that."""
HALF_WAY = 0.4
"""Where a panel that sticks half-way stands, by its share; it sticks within `STICKY` of it."""
STICKY = 0.03


class Fault(StrEnum):
    """What may befall a peripheral."""

    NONE = ""
    """It works."""
    JAMMED = "jammed"
    """Its motor reports an error and moves nothing."""
    STICKS = "sticks"
    """It stops half-way, and tells so once it has noticed."""
    SILENT = "silent"
    """Its software has failed: nothing is received from it and it does nothing."""
    SHUTS = "shuts"
    """It closes whenever nothing is under it, whatever its script says."""


class SimulatedMechanism:
    """The panels of one peripheral. Implements `robots.adapters.peripheral.Mechanism`."""

    def __init__(self, spec: Peripheral, scene: Scene, state: PeripheralState | None = None) -> None:
        self._spec = spec
        self._scene = scene
        self._panels = spec.panels
        self._bodies = [scene.put_panel(panel) for panel in self._panels]
        self._wanted = self._at = spec.state_at_start
        self._rides_s = 0.0
        self._blocked_s = 0.0
        self._stuck_s = 0.0
        self.broken = Fault.NONE
        self._shares = list(self._standing(self._at))
        if state is not None:
            self._shares = list(state.shares)
            self._at = state.at
            self._wanted = state.wanted
            self._rides_s = state.rides_s
            self.broken = Fault(state.fault)
        for number in range(len(self._panels)):
            self._show(number)

    def snapshot(self, memory: str) -> PeripheralState:
        return PeripheralState(
            shares=tuple(self._shares),
            at=self._at,
            wanted=self._wanted,
            rides_s=self._rides_s,
            fault=self.broken.value,
            memory=memory,
        )

    @property
    def state(self) -> str:
        standing = tuple(self._shares)
        if self._spec.is_lift:
            return self._at if standing == self._standing(self._at) else ""
        return next((state for state in (OPEN, CLOSED) if standing == self._standing(state)), "")

    @property
    def fault(self) -> str:
        if self.state == self._wanted:
            return ""
        if self.broken is Fault.JAMMED:
            return "its motor does not move"
        if self.broken is Fault.SHUTS and self._stuck_s >= SHUT_S:
            return "it does not stay open"
        if self._stuck_s >= BLOCKED_S:
            return "it is stuck half-way"
        if self._blocked_s >= BLOCKED_S:
            return f"{self._in_the_way() or 'something'} is in its way"
        return ""

    @property
    def is_moving(self) -> bool:
        return self.state != self._wanted and not self.fault

    def go_to(self, state: str) -> None:
        if state != self._wanted:
            self._wanted = state
            self._rides_s = 0.0
            self._blocked_s = 0.0
            self._stuck_s = 0.0

    def stop(self) -> None:
        """It goes where it was going: a panel is not left half-way."""

    def move(self, step_s: float) -> None:
        """Move the panels for a time."""
        shuts = self.broken is Fault.SHUTS and not self._spec.is_lift and not self._in_the_way()
        if self.broken is Fault.JAMMED or (self.state == self._wanted and not shuts):
            return
        if shuts and self.state == CLOSED != self._wanted:
            self._stuck_s += step_s
            return
        if self._spec.is_lift:
            self._ride(step_s)
        else:
            self._at = self._wanted
            self._move_panels(step_s, to_closed=shuts)

    def _ride(self, step_s: float) -> None:
        """Close the doors, ride, open the door of the level."""
        if self._at != self._wanted:
            if any(self._shares):
                self._move_panels(step_s, to_closed=True)
                return
            self._rides_s += step_s
            if self._rides_s < self._spec.travel_s:
                return
            self._at = self._wanted
        self._move_panels(step_s)

    def _move_panels(self, step_s: float, *, to_closed: bool = False) -> None:
        goals = self._standing(self._wanted)
        for number in range(len(self._panels)):
            goal = 0.0 if to_closed else goals[number]
            share = self._shares[number]
            if share == goal:
                continue
            if goal < share and self._scene.is_under(self._panels[number]):
                self._blocked_s += step_s
                self._shares[number] = min(1.0, share + step_s / self._spec.opening_s)
            elif self.broken is Fault.STICKS and abs(share - HALF_WAY) < STICKY:
                self._stuck_s += step_s
                continue
            else:
                self._stuck_s = 0.0
                if goal > share:
                    self._shares[number] = min(goal, share + step_s / self._spec.opening_s)
                else:
                    self._shares[number] = max(goal, share - step_s / self._spec.closing_s)
            self._show(number)

    def _standing(self, state: str) -> tuple[float, ...]:
        """How far each panel is raised in a state."""
        if self._spec.is_lift:
            return tuple(float(level == state) for level in self._spec.levels)
        return (float(state == OPEN),)

    def _in_the_way(self) -> str:
        return next(filter(None, map(self._scene.is_under, self._panels)), "")

    def _show(self, number: int) -> None:
        panel: Panel = self._panels[number]
        self._scene.raise_panel(self._bodies[number], panel, self._shares[number])
