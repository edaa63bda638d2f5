"""Which bodies the robots of a world file have, and which sonar."""

from collections.abc import Mapping, Sequence

import numpy as np

from robots.body import Pose
from robots.sensing.sonar import VirtualSonar
from robots.world import RobotSpec
from robots.world.bodies import AvatarBodySpec, VelocityBodySpec, WheeledBodySpec
from sim.bodies.avatar import AvatarBody
from sim.bodies.base import SimulatedBody
from sim.bodies.floor import FloorMap
from sim.bodies.odometry import Odometry
from sim.bodies.velocity import VelocityBody
from sim.bodies.wheeled import WheeledBody
from sim.bodies.workbench import SharedScene
from sim.physics.jaws import Jaws
from sim.physics.scene import Scene


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

    :param floor: what an avatar goes by, which nothing stops.
    :param told: the pose from which each one's odometry counts.
    """
    avatars = [spec.name for spec in specs if isinstance(spec.body, AvatarBodySpec)]
    bodies = {}
    for spec in specs:
        body = bodies[spec.name] = _made(spec, scene, floor, jaws, told[spec.name], rngs[spec.name])
        others = [avatar for avatar in avatars if avatar != spec.name]
        if "virtual" in spec.sonar and others:
            body.install(_virtual_sonar(spec, scene, others))
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


def _virtual_sonar(spec: RobotSpec, scene: Scene, others: Sequence[str]) -> VirtualSonar:
    return VirtualSonar(
        SharedScene(scene, spec.name, others),
        beams=spec.whiskers,
        range_m=spec.whisker_range_m,
        least_m=spec.whisker_least_m,
    )
