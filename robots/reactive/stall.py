"""Notices that a packet gets nowhere, and tries to shake it loose: back off, turn, try again. All of it our
choice.
"""

from cmath import phase
from math import inf, isfinite, pi

from robots.data import Checked
from robots.perception.percepts import LOCATING, SURROUNDINGS, Needs, Percepts
from robots.reactive.synthesis import Motion

STALLED_S = 7.0
"""A packet without progress towards its goal for this long has stalled."""
RETRIES = 4
"""Retry manoeuvres before a packet is given up, unless the packet states another number."""
NEARER_M = 0.05
MOVED_M = 0.06
TURNED_RAD = 0.25
BACK_OFF_S, TURN_S = 1.6, 1.2
REAR_GAP_M = 0.12
WATCHED: Needs = LOCATING
"""What tells of progress."""
BACKS_OFF: Needs = SURROUNDINGS
"""What the manoeuvre asks for: whether the way back is free."""


class StallMemory(Checked):
    """How far a packet's patience has come; seconds and metres. `best_m` is None before there is any."""

    retries: int = 0
    idle_s: float = 0.0
    manoeuvre_s: float | None = None
    best_m: float | None = None


class StallGuard:
    """Watches one packet's progress: towards its goal if it has one, else any movement or change of the
    gripper.
    """

    def __init__(self, goal: str | None, retries: int = RETRIES, stalled_s: float = STALLED_S) -> None:
        self._goal, self._stalled_s = goal, stalled_s
        self.allowed = retries
        self._best_m = inf
        self._mark: tuple[complex, float, str | None] | None = None
        self._idle_s = 0.0
        self._manoeuvre_s: float | None = None
        self.retries = 0

    def memory(self) -> StallMemory:
        """What to go on with after a power failure; where it was last seen to move it finds out anew."""
        return StallMemory(
            retries=self.retries,
            idle_s=self._idle_s,
            manoeuvre_s=self._manoeuvre_s,
            best_m=self._best_m if isfinite(self._best_m) else None,
        )

    def recall(self, memory: StallMemory) -> None:
        self.retries, self._idle_s, self._manoeuvre_s = memory.retries, memory.idle_s, memory.manoeuvre_s
        self._best_m = inf if memory.best_m is None else memory.best_m

    @property
    def stalled(self) -> bool:
        return self._idle_s >= self._stalled_s

    @property
    def spent(self) -> bool:
        """True if it has stalled more often than there are retries."""
        return self.stalled and self.retries >= self.allowed

    @property
    def manoeuvring(self) -> bool:
        """True while it shakes the robot loose."""
        return self._manoeuvre_s is not None

    def watch(self, percepts: Percepts, step_s: float) -> None:
        """Account for one tick in which the packet's patterns were active."""
        self._idle_s = 0.0 if self._progressed(percepts) else self._idle_s + step_s

    def begin_manoeuvre(self) -> None:
        self.retries += 1
        self._manoeuvre_s = 0.0
        self._idle_s = 0.0
        self._best_m = inf

    def manoeuvre(
        self, percepts: Percepts, step_s: float, speed_m_s: float, turn_rad_s: float
    ) -> Motion | None:
        """The retry manoeuvre's motion; None when none is under way."""
        if self._manoeuvre_s is None:
            return None
        self._manoeuvre_s += step_s
        if self._manoeuvre_s <= BACK_OFF_S:
            return Motion(linear_m_s=-0.4 * speed_m_s if _rear_is_free(percepts) else 0.0)
        if self._manoeuvre_s <= BACK_OFF_S + TURN_S:
            side = -1 if self.retries % 2 else 1  # to the right first, as robots that meet pass
            return Motion(angular_rad_s=side * 0.5 * turn_rad_s)
        self._manoeuvre_s = None
        return None

    def _progressed(self, percepts: Percepts) -> bool:
        goal = self._goal
        point = (percepts.approach_point(goal) or percepts.locate(goal)) if goal is not None else None
        if point is not None and abs(point) > 0.3:
            if abs(point) < self._best_m - NEARER_M:
                self._best_m = abs(point)
                return True
            return False
        here = (complex(percepts.pose.x_m, percepts.pose.y_m), percepts.pose.heading_rad, percepts.holding)
        mark = self._mark
        turned = 0.0 if mark is None else abs((here[1] - mark[1] + pi) % (2 * pi) - pi)
        if mark is None or abs(here[0] - mark[0]) > MOVED_M or turned > TURNED_RAD or here[2] != mark[2]:
            self._mark = here
            return True
        return False


def _rear_is_free(percepts: Percepts) -> bool:
    return all(one.gap_m > REAR_GAP_M for one in percepts.obstacles if abs(phase(one.at)) > 2.0)
