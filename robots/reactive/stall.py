"""Detects that a packet makes no progress, and retries: back off, turn, go on. All of it our choice."""

from cmath import phase
from math import hypot
from typing import NamedTuple

from robots.data import Memory
from robots.perception.percepts import LOCATING, SURROUNDINGS, Needs, Percepts
from robots.physical.body import Pose
from robots.physical.geometry import wrap
from robots.reactive.synthesis import Motion

STALLED_S = 7.0
"""A packet without progress towards its goal for this long has stalled."""
RETRIES = 4
"""Retry manoeuvres before a packet is given up, unless the packet states another number."""
NEARER_M = 0.05
MOVED_M = 0.06
TURNED_RAD = 0.25
BACK_OFF_S = 1.6
TURN_S = 1.2
REAR_GAP_M = 0.12
WATCHED: Needs = LOCATING
"""The sensors that measure progress."""
BACKS_OFF: Needs = SURROUNDINGS
"""The sensors of the retry manoeuvre."""


class StallMemory(Memory):
    """The state of a guard. `best_m`: None before the first distance."""

    retries: int = 0
    idle_s: float = 0.0
    manoeuvre_s: float | None = None
    best_m: float | None = None


class Mark(NamedTuple):
    """The pose at the last movement, and what the robot held then."""

    pose: Pose
    holding: str | None

    def differs_from(self, other: "Mark") -> bool:
        moved_m = hypot(self.pose.x_m - other.pose.x_m, self.pose.y_m - other.pose.y_m)
        turned_rad = abs(wrap(self.pose.heading_rad - other.pose.heading_rad))
        return moved_m > MOVED_M or turned_rad > TURNED_RAD or self.holding != other.holding


class StallGuard:
    """Watches one packet's progress: towards its goal if it has one, else any movement or change of the gripper."""

    def __init__(self, goal: str | None, retries: int = RETRIES, stalled_s: float = STALLED_S) -> None:
        self._goal = goal
        self._stalled_s = stalled_s
        self.allowed = retries
        self.state = StallMemory()
        self._mark: Mark | None = None

    @property
    def stalled(self) -> bool:
        return self.state.idle_s >= self._stalled_s

    @property
    def spent(self) -> bool:
        """True if it has stalled and no retry is left."""
        return self.stalled and self.state.retries >= self.allowed

    @property
    def manoeuvring(self) -> bool:
        """True during the retry manoeuvre."""
        return self.state.manoeuvre_s is not None

    def watch(self, percepts: Percepts, step_s: float) -> None:
        """Account for one tick in which the patterns acted."""
        self.state.idle_s = 0.0 if self._progressed(percepts) else self.state.idle_s + step_s

    def begin_manoeuvre(self) -> None:
        self.state.retries += 1
        self.state.manoeuvre_s = 0.0
        self.state.idle_s = 0.0
        self.state.best_m = None

    def forget_distance(self) -> None:
        """Measure progress anew: something else has moved the robot."""
        self.state.best_m = None
        self.state.idle_s = 0.0
        self.state.manoeuvre_s = None
        self._mark = None

    def manoeuvre(
        self, percepts: Percepts, step_s: float, speed_m_s: float, turn_rad_s: float
    ) -> Motion | None:
        """The motion of the retry manoeuvre; None without one."""
        if self.state.manoeuvre_s is None:
            return None
        self.state.manoeuvre_s += step_s
        if self.state.manoeuvre_s <= BACK_OFF_S:
            return Motion(linear_m_s=-0.4 * speed_m_s if _rear_is_free(percepts) else 0.0)
        if self.state.manoeuvre_s <= BACK_OFF_S + TURN_S:
            side = -1 if self.state.retries % 2 else 1  # to the right first, as robots that meet pass
            return Motion(angular_rad_s=side * 0.5 * turn_rad_s)
        self.state.manoeuvre_s = None
        return None

    def _progressed(self, percepts: Percepts) -> bool:
        goal = self._goal
        point = (percepts.approach_point(goal) or percepts.locate(goal)) if goal is not None else None
        if point is not None and abs(point) > 0.3:
            best_m = self.state.best_m
            if best_m is not None and abs(point) >= best_m - NEARER_M:
                return False
            self.state.best_m = abs(point)
            return True
        here = Mark(percepts.pose, percepts.holding)
        if self._mark is None or here.differs_from(self._mark):
            self._mark = here
            return True
        return False


def _rear_is_free(percepts: Percepts) -> bool:
    return all(one.gap_m > REAR_GAP_M for one in percepts.obstacles if abs(phase(one.at)) > 2.0)
