"""Detects that a packet makes no progress, and counts its retries (our choice).

The manoeuvre of a retry is patterns, like all motion: the self level's (robots/repertoire/self_level.yaml), unless the
packet states its own.
"""

from collections.abc import Container, Iterable
from math import hypot
from typing import NamedTuple

from robots.data import Memory
from robots.perception.percepts import LOCATING, Needs, Percepts
from robots.perception.progress import Progress
from robots.physical.body import Pose
from robots.physical.geometry import wrap

STALLED_S = 7.0
"""A packet without progress towards its goal for this long has stalled."""
RETRIES = 4
"""Retry manoeuvres before a packet is given up, unless the packet states another number."""
NEARER_M = 0.05
MOVED_M = 0.06
TURNED_RAD = 0.25
STUCK = "stuck"
"""The event of a packet that has stalled and may be retried."""
MET = "met"
"""Beside it: another robot is near."""
MISSED = "missed"
"""Beside it: the packet is to grip something, and the jaws hold nothing."""
CAUSES = frozenset({MET, MISSED})
WATCHED: Needs = LOCATING
"""The sensors that measure progress."""


def for_rules(events: Iterable[str], left_to_rules: Container[str]) -> tuple[str, ...]:
    """The events as rules hear them: without `stuck` where they act on its cause."""
    named = tuple(events)
    has_cause = any(one in CAUSES and one in left_to_rules for one in named)
    return tuple(one for one in named if one != STUCK or not has_cause)


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

    def retry(self, *, manoeuvre: bool) -> None:
        """Count a retry, and begin its manoeuvre; without one, something else frees the robot."""
        self.state.retries += 1
        self.state.manoeuvre_s = 0.0 if manoeuvre else None
        self.state.idle_s = 0.0
        self.state.best_m = None

    def forget_distance(self) -> None:
        """Measure progress anew: something else has moved the robot."""
        self.state.best_m = None
        self.state.idle_s = 0.0
        self.state.manoeuvre_s = None
        self._mark = None

    def manoeuvre(self, step_s: float, retry_s: float) -> Progress | None:
        """The progress of the manoeuvre, of which a tick has passed; None without one, or once it has ended."""
        if self.state.manoeuvre_s is None:
            return None
        self.state.manoeuvre_s += step_s
        if self.state.manoeuvre_s <= retry_s:
            return Progress(elapsed_s=self.state.manoeuvre_s, retries=self.state.retries)
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
