"""Grippers and samples: what the light barriers meet, and who holds what.

Our choices: closing jaws lift what is between them at once, so that it passes above standing samples and the
whiskers' plane; a held sample touches nothing, only the rover's jaws are solid. Two robots may hold one
sample (MACTA's RELEASE1): it follows the first of them, and slips out of the other's jaws if they part.
"""

from collections.abc import Sequence
from math import cos, hypot, sin

from robots.body import GRIPPER_REACH_M, Gripper, Pose
from sim.scene import Scene

BARRIER_M = 0.07
"""The light barrier meets a sample whose middle is this near to the jaws' middle."""
SLIP_M = 0.15
"""A sample farther than this from a second holder's jaws has slipped out."""


def jaws_point(pose: Pose) -> tuple[float, float]:
    """The middle of the jaws, in the world's frame."""
    ahead = (GRIPPER_REACH_M * cos(pose.heading_rad), GRIPPER_REACH_M * sin(pose.heading_rad))
    return (pose.x_m + ahead[0], pose.y_m + ahead[1])


class Jaws:
    """The grippers of all rovers of one scene."""

    def __init__(self, scene: Scene, rovers: Sequence[str], samples: Sequence[str]) -> None:
        self._scene = scene
        self._closed = dict.fromkeys(rovers, False)
        self._holders: dict[str, list[str]] = {sample: [] for sample in samples}

    def holders(self, sample: str) -> tuple[str, ...]:
        """The rovers that hold a sample, the one that carries it first."""
        return tuple(self._holders[sample])

    def state(self, rover: str) -> Gripper:
        """The gripper's own sensing."""
        held = self._held_by(rover)
        if self._closed[rover]:
            return Gripper(closed=True, between_jaws=held)
        return Gripper(closed=False, between_jaws=self._between(rover))

    def move(self, rover: str, *, closed: bool) -> None:
        """Close or open. Closing on a sample grips and lifts it, opening sets it down below the jaws."""
        if closed == self._closed[rover]:
            return
        sample = self._between(rover) if closed else self._held_by(rover)
        self._closed[rover] = closed
        if sample is not None:
            self._grip(rover, sample) if closed else self._let_go(rover, sample)

    def carry(self) -> None:
        """Bring every held sample to its carrier's jaws."""
        for sample, holders in self._holders.items():
            if not holders:
                continue
            point = jaws_point(self._scene.pose(holders[0]))
            self._scene.carry(sample, point)
            for other in holders[1:]:
                if _distance_m(point, jaws_point(self._scene.pose(other))) > SLIP_M:
                    holders.remove(other)

    def _grip(self, rover: str, sample: str) -> None:
        if not self._holders[sample]:
            self._scene.lift(sample)
        self._holders[sample].append(rover)

    def _let_go(self, rover: str, sample: str) -> None:
        point = self._scene.sample_point(sample)
        self._holders[sample].remove(rover)
        if not self._holders[sample]:
            self._scene.set_down(sample, point[:2])

    def _held_by(self, rover: str) -> str | None:
        return next((sample for sample, holders in self._holders.items() if rover in holders), None)

    def _between(self, rover: str) -> str | None:
        jaws = jaws_point(self._scene.pose(rover))
        near = [(_distance_m(self._scene.sample_point(sample)[:2], jaws), sample) for sample in self._holders]
        distance_m, sample = min(near, default=(float("inf"), ""))
        return sample if distance_m <= BARRIER_M else None


def _distance_m(one: tuple[float, float], other: tuple[float, float]) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])
