"""The shared environment of solid robots and avatars, as one of them sees it."""

from collections.abc import Sequence

from robots.geometry import to_robot
from sim.physics.scene import Scene


class SharedScene:
    """Implements `robots.sensing.sonar.Workbench` by the scene's own poses (our choice: without delay and noise)."""

    def __init__(self, scene: Scene, robot: str, others: Sequence[str]) -> None:
        """:param others: the avatars around."""
        self._scene, self._robot, self._others = scene, robot, tuple(others)

    def simulated_robots(self) -> Sequence[complex]:
        here = self._scene.pose(self._robot)
        there = (self._scene.pose(other) for other in self._others)
        return [to_robot(here, complex(pose.x_m, pose.y_m)) for pose in there]
