"""A robot's further sensors in a world file: kinds that installed packages register, alone or with parameters."""

from typing import Annotated

from robots.extensions import SENSORS
from robots.world.package_parts import PackagePartSpec, PartOfPackage


class PackageSensorSpec(PackagePartSpec):
    """A sensor of an installed package: a subclass, registered as `macta.sensors` under its kind, adds its parameters.

    The simulation makes the sensor with the subclass's `make_sensor` (`sim.bodies.factory.MakesSensor`); it is an
    activity that puts what it measures into `Readings.measured`.
    """


SensorSpec = Annotated[
    PackageSensorSpec,
    PartOfPackage(group=SENSORS, base=PackageSensorSpec, stated_as=str | PackageSensorSpec),
]
