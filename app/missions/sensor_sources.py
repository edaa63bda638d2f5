"""Where a robot's readings come from: from its sensors, or from their virtual counterparts (SRA)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from app.agents.tuning import robot_and_world
from app.domain.errors import Conflict, NotFound
from app.domain.world_model.edits import RINGS, ChangeRobot
from app.missions.world_changes import WorldChanges
from robots.physical.body import Sensor
from robots.world import WorldFile
from robots.world.parts import SonarPart

RANGES = Sensor.ULTRASONIC.value
"""The sensor that has a virtual counterpart."""


class SensorSource(StrEnum):
    """Where a sensor's readings come from."""

    REAL = "real"
    """The body's own sensor; in a simulation that of the simulated body."""
    VIRTUAL = "virtual"
    """Its virtual counterpart: the readings that the map would give it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourcedSensor:
    """A sensor of a robot and the source of its readings. `edition`: of the world."""

    robot: str
    sensor: str
    source: SensorSource
    edition: int


class SensorSources:
    """Replaces sensors by their virtual counterparts, as editions of the world, and back."""

    def __init__(self, *, worlds: Mapping[str, WorldFile], changes: WorldChanges) -> None:
        self._worlds = worlds
        self._changes = changes

    def of_robot(self, robot: str) -> Sequence[SourcedSensor]:
        """The robot's sensors that have a virtual counterpart."""
        spec, world = robot_and_world(self._worlds, robot)
        if RINGS.isdisjoint(spec.sonar):
            return ()
        source = SensorSource.VIRTUAL if "map" in spec.sonar else SensorSource.REAL
        edition = self._changes.edition(world)
        return [SourcedSensor(robot=robot, sensor=RANGES, source=source, edition=edition)]

    def put(
        self, robot: str, sensor: str, source: SensorSource, *, actor: str, comment: str
    ) -> SourcedSensor:
        """Have the sensor's readings come from this source; its mission goes on.

        :raises NotFound: if the sensor has no virtual counterpart, or the robot no such sensor.
        :raises Conflict: if software of its own reads the robot's sensors.
        :raises Outdated: if the world is changed meanwhile.
        """
        _, world = robot_and_world(self._worlds, robot)
        edition = self._changes.edition(world)
        spec, _ = robot_and_world(self._worlds, robot)
        if sensor != RANGES:
            raise NotFound(
                f"{sensor} has no virtual counterpart", code="unknown-sensor", choices=(RANGES,), thing=sensor
            )
        if spec.external:
            raise Conflict(
                f"software of its own reads the sensors of {robot}", code="robot-is-external", thing=robot
            )
        if RINGS.isdisjoint(spec.sonar):
            raise NotFound(f"{robot} has no {sensor} ring", code="unknown-sensor", thing=sensor)
        rings: dict[SensorSource, SonarPart] = {SensorSource.REAL: "real", SensorSource.VIRTUAL: "map"}
        others: list[SonarPart] = [one for one in spec.sonar if one not in RINGS]
        sonar = (rings[source], *others)
        if sonar != spec.sonar:
            self._changes.change(
                world,
                [ChangeRobot(name=robot, sonar=sonar)],
                actor=actor,
                source=f"operator {actor}",
                reason=comment or f"the {sensor} ring of {robot} is {source.value}",
                expected=edition,
            )
        return next(one for one in self.of_robot(robot) if one.sensor == sensor)
