"""Makes the body and the sonar that the world file names for each robot."""

from cmath import rect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, cast, runtime_checkable

import numpy as np

from robots.physical.body import Image, Pose, Readings
from robots.physical.geometry import to_robot
from robots.physical.sonar import Activity, MapSonar, VirtualSonar, Walls
from robots.world import RobotSpec
from robots.world.bodies import AvatarBodySpec, PackageBodySpec, VelocityBodySpec, WheeledBodySpec
from robots.world.sensors import CameraSpec, PackageSensorSpec, ScannerSpec
from robots.world.walls import WALL_THICKNESS_M
from sim.bodies.avatar import AvatarBody, FloorMap
from sim.bodies.base import Camera, SimulatedBody
from sim.bodies.odometry import Odometry
from sim.bodies.velocity import VelocityBody
from sim.bodies.wheeled import WheeledBody
from sim.error import SimulationError
from sim.physics.camera import png
from sim.physics.jaws import Jaws
from sim.physics.scene import Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyParts:
    """What a body of a package is made with: its robot, its odometry, the scene that moves it, and its noise."""

    spec: RobotSpec
    jaws: Jaws
    scene: Scene
    odometry: Odometry
    rng: np.random.Generator


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorSite:
    """Where a sensor of a package is: its robot, the scene around it, and its noise.

    Between two ticks it may keep nothing but what `rng` does: snapshots have no place for it.
    """

    spec: RobotSpec
    scene: Scene
    rng: np.random.Generator

    def pose(self) -> Pose:
        """The robot's true pose."""
        return self.scene.pose(self.spec.name)

    def image(self, *, width: int = 240, height: int = 180, view_deg: float = 50) -> Image:
        """What a camera on the robot sees straight ahead, as PNG.

        :param width, height: pixels. :param view_deg: the angle of view, from top to bottom.
        """
        pixels = self.scene.picture(self.spec.name, width=width, height=height, view_deg=view_deg)
        return Image(media_type="image/png", data=png(pixels))


@runtime_checkable
class MakesSensor(Protocol):
    """What a package's `PackageSensorSpec` has so that its sensor can be simulated."""

    def make_sensor(self, site: SensorSite) -> Activity | Camera: ...


@runtime_checkable
class MakesBody(Protocol):
    """What a package's `PackageBodySpec` has so that its body can be simulated."""

    def make_body(self, parts: BodyParts) -> SimulatedBody: ...


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


class MapAround:
    """The walls and closed doors around a robot. Implements `robots.physical.sonar.KnowsWalls`."""

    def __init__(self, scene: Scene, robot: str, floor: FloorMap) -> None:
        self._scene = scene
        self._robot = robot
        self._walls = floor.walls

    def walls(self) -> Walls:
        here = self._scene.pose(self._robot)
        doors = FloorMap(tuple(self._scene.lowered_panels)).walls
        there: Walls = np.concatenate((self._walls, doors)) - complex(here.x_m, here.y_m)
        turned: Walls = there * rect(1.0, -here.heading_rad)
        return turned


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
        if "map" in spec.sonar:
            body.install(
                MapSonar(
                    MapAround(scene, spec.name, floor),
                    beams=spec.whiskers,
                    range_m=spec.whisker_range_m,
                    least_m=spec.whisker_least_m,
                    thickness_m=WALL_THICKNESS_M,
                )
            )
        if "virtual" in spec.sonar and others:
            body.install(
                VirtualSonar(
                    SharedScene(scene, spec.name, others),
                    beams=spec.whiskers,
                    range_m=spec.whisker_range_m,
                    least_m=spec.whisker_least_m,
                )
            )
        for sensor in spec.sensors:
            _install(body, sensor, SensorSite(spec=spec, scene=scene, rng=rngs[spec.name]))
    return bodies


@dataclass(frozen=True, slots=True)
class SceneCamera:
    """The camera that ships with Macta. Implements `Camera`."""

    spec: CameraSpec
    site: SensorSite

    def take(self) -> Image:
        spec = self.spec
        return self.site.image(width=spec.width, height=spec.height, view_deg=spec.view_deg)


@dataclass(frozen=True, slots=True)
class WhiskerScanner:
    """The scanner that ships with Macta. It measures nothing while the whiskers are off. Implements `Activity`."""

    spec: ScannerSpec

    def process(self, readings: Readings) -> Readings:
        if readings.ranges_m is None:
            return readings
        clutter = float((readings.ranges_m <= self.spec.reach_m).mean())
        return replace(readings, measured={**readings.measured, "clutter": clutter})


def _install(
    body: SimulatedBody, sensor: CameraSpec | ScannerSpec | PackageSensorSpec, site: SensorSite
) -> None:
    if isinstance(sensor, CameraSpec):
        body.install_camera(sensor.kind, SceneCamera(sensor, site))
        return
    if isinstance(sensor, ScannerSpec):
        body.install(WhiskerScanner(sensor))
        return
    if not isinstance(sensor, MakesSensor):
        raise SimulationError(
            f"{site.spec.name}: a sensor of kind {sensor.kind} cannot be simulated: no make_sensor"
        )
    made = sensor.make_sensor(site)
    if sensor.takes_images:
        body.install_camera(sensor.kind, cast(Camera, made))
    else:
        body.install(cast(Activity, made))


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
        case PackageBodySpec() as body:
            if not isinstance(body, MakesBody):
                raise SimulationError(
                    f"{spec.name}: a body of kind {body.kind} cannot be simulated: no make_body"
                )
            odometry = Odometry(told, scene.pose(spec.name), rng)
            return body.make_body(BodyParts(spec=spec, jaws=jaws, scene=scene, odometry=odometry, rng=rng))
