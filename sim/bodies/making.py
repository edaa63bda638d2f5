"""Which body a robot of the world file has."""

import numpy as np

from robots.body import Pose
from robots.world import RobotSpec
from sim.bodies.odometry import Odometry
from sim.bodies.simulated import SimulatedBody
from sim.bodies.velocity import VelocityBody
from sim.jaws import Jaws
from sim.scene import Scene


def make_body(
    spec: RobotSpec, *, scene: Scene, jaws: Jaws, told: Pose, rng: np.random.Generator
) -> SimulatedBody:
    """The body that the robot's spec names.

    :param told: the pose from which its odometry counts.
    """
    return VelocityBody(spec, jaws, scene, Odometry(told, scene.pose(spec.name), rng))
