"""Makes the body and the sonar that the world file names for each robot."""

from collections.abc import Mapping, Sequence

import numpy as np

from robots.physical.body import Pose
from robots.physical.geometry import to_robot
from robots.physical.sonar import VirtualSonar
from robots.world import RobotSpec
from robots.world.bodies import AvatarBodySpec, VelocityBodySpec, WheeledBodySpec
from sim.bodies.avatar import AvatarBody, FloorMap
from sim.bodies.base import SimulatedBody
from sim.bodies.odometry import Odometry
from sim.bodies.velocity import VelocityBody
from sim.bodies.wheeled import WheeledBody
from sim.physics.jaws import Jaws
from sim.physics.scene import Scene


class SharedScene:
    """The shared environment of solid robots and avatars, as one of them sees it.

    Implements `robots.physical.sonar.Workbench` by the scene's own poses (our choice: without delay and noise).
    """

    def __init__(self, scene: Scene, robot: str, avatars: Sequence[str]) -> None:
        self._scene = scene
        self._robot = robot
        self._avatars = tuple(avatars)

    def simulated_robots(self) -> Sequence[complex]:
        here = self._scene.pose(self._robot)
        there = (self._scene.pose(avatar) for avatar in self._avatars)
        return [to_robot(here, complex(pose.x_m, pose.y_m)) for pose in there]


def make_bodies(
    specs: Sequence[RobotSpec],
    *,
    scene: Scene,
    floor: FloorMap,
    jaws: Jaws,
    told: Mapping[str, Pose],
    rngs: Mapping[str, np.random.Generator],
) -> dict[str, SimulatedBody]:
    """The bodies that the specs name, with their activities installed.

    :param floor: the map that stops an avatar.
    :param told: the pose from which each one's odometry counts.
    """
    avatars = [spec.name for spec in specs if isinstance(spec.body, AvatarBodySpec)]
    bodies = {}
    for spec in specs:
        body = bodies[spec.name] = _made(spec, scene, floor, jaws, told[spec.name], rngs[spec.name])
        others = [avatar for avatar in avatars if avatar != spec.name]
        if "virtual" in spec.sonar and others:
            body.install(
                VirtualSonar(
                    SharedScene(scene, spec.name, others),
                    beams=spec.whiskers,
                    range_m=spec.whisker_range_m,
                    least_m=spec.whisker_least_m,
                )
            )
    return bodies


def _made(
    spec: RobotSpec, scene: Scene, floor: FloorMap, jaws: Jaws, told: Pose, rng: np.random.Generator
) -> SimulatedBody:
    match spec.body:
        case WheeledBodySpec():
            return WheeledBody(spec, spec.body, jaws, scene, told, rng)
        case VelocityBodySpec():
            return VelocityBody(spec, spec.body, jaws, scene, Odometry(told, scene.pose(spec.name), rng))
        case AvatarBodySpec():
            return AvatarBody(spec, spec.body, jaws, scene, Odometry(told, scene.pose(spec.name), rng), floor)
