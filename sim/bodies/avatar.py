"""The virtual avatar (SRA, Virtual Robotic Workbench): a robot without a physical body, which moves by itself.

It meets nothing and nothing meets it; other robots see its beacon, and hear it by virtual sonar only. The map alone
stops it. Its jaws work as all jaws do (our choice): what they hold goes with them.
"""

from math import hypot, remainder, tau

from robots.body import Pose
from robots.world import RobotSpec
from robots.world.bodies import Ramps
from sim.bodies.floor import FRONT_M, FloorMap
from sim.bodies.odometry import Odometry, reckoned
from sim.bodies.velocity import RampedBody
from sim.physics.jaws import Jaws
from sim.physics.scene import TICK_S, Scene


class AvatarBody(RampedBody):
    """Integrates its own pose; a step that would end in a wall is not made, but for the part of it that would not."""

    def __init__(
        self,
        spec: RobotSpec,
        ramps: Ramps,
        jaws: Jaws,
        scene: Scene,
        odometry: Odometry,
        floor: FloorMap,
    ) -> None:
        super().__init__(spec, ramps, jaws, scene, odometry)
        self._floor = floor
        self._stopped = False
        self._asked = scene.pose(spec.name)
        self._room_m = floor.room_m(self._asked)
        scene.disembody(spec.name)

    def drive(self) -> None:
        self._ramp()
        self._stopped = False
        if self._driven != (0.0, 0.0):
            self._scene.put_rover(self.spec.name, self._stepped(self._scene.pose(self.spec.name)))

    def touches(self) -> bool:
        """True while a wall stops it."""
        return self._stopped

    def _stepped(self, pose: Pose) -> Pose:
        """The whole step, if a wall is in its way only the turn or only the way, else none."""
        ahead_m, turn_rad = self._driven[0] * TICK_S, self._driven[1] * TICK_S
        for way in ((ahead_m, turn_rad), (0.0, turn_rad), (ahead_m, 0.0)):
            then = reckoned(pose, *way)
            if self._is_free(then) or self._floor.room_m(then) >= self._floor.room_m(pose):
                return then
            self._stopped = True
        return pose

    def _is_free(self, then: Pose) -> bool:
        """Whether it stands clear there. The map is asked only beyond the room that was found last time."""
        off_m = hypot(then.x_m - self._asked.x_m, then.y_m - self._asked.y_m)
        off_m += FRONT_M * abs(remainder(then.heading_rad - self._asked.heading_rad, tau))
        if off_m >= self._room_m:
            self._asked, self._room_m = then, self._floor.room_m(then)
            return self._room_m >= 0
        return True
