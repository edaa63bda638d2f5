"""Which body a robot of the world file has."""

import numpy as np

from robots.body import Pose
from robots.world import RobotSpec
from robots.world.bodies import AvatarBodySpec, VelocityBodySpec, WheeledBodySpec
from sim.bodies.avatar import AvatarBody
from sim.bodies.floor import FloorMap
from sim.bodies.odometry import Odometry
from sim.bodies.simulated import SimulatedBody
from sim.bodies.velocity import VelocityBody
from sim.bodies.wheeled import WheeledBody
from sim.jaws import Jaws
from sim.scene import Scene


def make_body(
    spec: RobotSpec, *, scene: Scene, floor: FloorMap, jaws: Jaws, told: Pose, rng: np.random.Generator
) -> SimulatedBody:
    """The body that the robot's spec names.

    :param floor: what an avatar goes by, which nothing stops.
    :param told: the pose from which its odometry counts.
    """
    match spec.body:
        case WheeledBodySpec():
            return WheeledBody(spec, spec.body, jaws, scene, told, rng)
        case VelocityBodySpec():
            return VelocityBody(spec, spec.body, jaws, scene, Odometry(told, scene.pose(spec.name), rng))
        case AvatarBodySpec():
            return AvatarBody(spec, spec.body, jaws, scene, Odometry(told, scene.pose(spec.name), rng), floor)
