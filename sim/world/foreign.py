"""Robots of the world that others drive: obstacles and marks at their reported poses, and what they have moved.

The simulation follows the record here: a sample that such a robot has put down, or holds, is where it told.
"""

from collections.abc import Mapping, Sequence
from math import radians

from robots.physical.body import Pose
from robots.wire import ForeignState, MovedSample
from robots.world import Sample, WorldFile
from sim.physics.jaws import Jaws, jaws_point
from sim.physics.scene import Scene
from sim.snapshot import ForeignSnapshot


class ForeignRobots:
    """The foreign robots of one scene."""

    def __init__(
        self, world: WorldFile, samples: Sequence[Sample], scene: Scene, jaws: Jaws, names: Sequence[str]
    ) -> None:
        """:param samples: all that there are. :param names: of the robots."""
        self.names = tuple(names)
        self._world = world
        self._lengths_m = {one.name: one.length_m for one in samples}
        self._scene = scene
        self._jaws = jaws
        self._version = 0
        self._poses: dict[str, Pose] = {}
        self._moved: dict[str, tuple[str, float]] = {}
        """By sample, where it was last told to be and when: each move is followed once."""
        self._carried: dict[str, str] = {}

    @property
    def poses(self) -> Mapping[str, Pose]:
        """Where they were last reported; without those that were never heard."""
        return self._poses

    def holders(self, sample: str) -> tuple[str, ...]:
        """The robot that holds the sample, if one does."""
        return (self._carried[sample],) if sample in self._carried else ()

    def take(self, state: ForeignState) -> None:
        """Follow what is told, unless something newer was told before."""
        if state.version < self._version:
            return
        self._version = state.version
        for name, (x_m, y_m, heading_rad) in state.robots.items():
            if name in self.names:
                self._put(name, Pose(x_m=x_m, y_m=y_m, heading_rad=heading_rad))
        for moved in state.samples:
            self._follow(moved)
        for sample, robot in self._carried.items():
            self._bring(sample, robot)

    def snapshot(self) -> ForeignSnapshot:
        return ForeignSnapshot(
            version=self._version,
            robots=dict(self._poses),
            moved=dict(self._moved),
            carried=dict(self._carried),
        )

    def restore(self, snapshot: ForeignSnapshot) -> None:
        """Go on from a snapshot of the same world, or of an earlier edition; the samples are where they were."""
        self._version = snapshot.version
        self._moved = {sample: at for sample, at in snapshot.moved.items() if sample in self._lengths_m}
        for name, pose in snapshot.robots.items():
            if name in self.names:
                self._put(name, pose)
        for sample, robot in snapshot.carried.items():
            if sample in self._lengths_m and robot in self.names:
                self._lift(sample, robot)

    def _put(self, name: str, pose: Pose) -> None:
        if self._poses.get(name) != pose:
            self._scene.put_foreign(name, pose)
            self._poses[name] = pose

    def _follow(self, moved: MovedSample) -> None:
        told = (moved.place, moved.at_s)
        if moved.sample not in self._lengths_m or self._moved.get(moved.sample) == told:
            return
        is_place = moved.place in self._world.points
        if not is_place and moved.place not in self.names:
            return
        self._moved[moved.sample] = told
        if self._jaws.holders(moved.sample):
            return  # a simulated robot has it: its own reports are on the way
        if is_place:
            self._set_down(moved.sample, moved.place)
        else:
            self._lift(moved.sample, moved.place)

    def _set_down(self, sample: str, place: str) -> None:
        self._carried.pop(sample, None)
        location = self._world.location(place)
        across_rad = radians(location.approach_deg[0] + 90) if self._lengths_m[sample] else 0.0
        self._scene.set_down(sample, location.at, across_rad)

    def _lift(self, sample: str, robot: str) -> None:
        self._carried[sample] = robot
        self._scene.lift(sample)
        self._bring(sample, robot)

    def _bring(self, sample: str, robot: str) -> None:
        """A held sample is at its robot's jaws; where it was, if nobody knows where the robot is."""
        pose = self._poses.get(robot)
        at = self._scene.sample_point(sample)[:2] if pose is None else jaws_point(pose)
        heading_rad = self._scene.sample_heading(sample) if pose is None else pose.heading_rad
        self._scene.carry(sample, at, heading_rad)
