"""A robot's further sensors in a world file: kinds that installed packages register, alone or with parameters."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from robots.data import Checked
from robots.extensions import SENSORS
from robots.world.package_parts import PackagePartSpec, PartOfPackage


class PackageSensorSpec(PackagePartSpec):
    """A sensor of an installed package: a subclass, registered as `macta.sensors` under its kind, adds its parameters.

    The simulation makes the sensor with the subclass's `make_sensor` (`sim.bodies.factory.MakesSensor`); it is an
    activity that puts what it measures into `Readings.measured`, or, if it `takes_images`, a camera.
    """

    takes_images: ClassVar[bool] = False
    measures: ClassVar[frozenset[str] | None] = None
    """The quantities that it puts into `Readings.measured`; None: not stated."""


class CameraSpec(Checked):
    """A camera that looks straight ahead: the size of its image in pixels, its angle of view from top to bottom."""

    takes_images: ClassVar[bool] = True
    measures: ClassVar[frozenset[str] | None] = frozenset()

    kind: Literal["camera"]
    width: int = Field(default=240, ge=16, le=1280)
    height: int = Field(default=180, ge=16, le=960)
    view_deg: float = Field(default=50, ge=5, le=120)


class ScannerSpec(Checked):
    """Measures `clutter` by the robot's whiskers: the share of the circle around it with something within `reach_m`."""

    takes_images: ClassVar[bool] = False
    measures: ClassVar[frozenset[str] | None] = frozenset({"clutter"})

    kind: Literal["scanner"]
    reach_m: float = Field(default=2.0, ge=0.2, le=10)


ShippedSensorSpec = Annotated[CameraSpec | ScannerSpec, Field(discriminator="kind")]

SensorSpec = Annotated[
    CameraSpec | ScannerSpec | PackageSensorSpec,
    PartOfPackage(
        group=SENSORS,
        base=PackageSensorSpec,
        shipped=ShippedSensorSpec,
        kinds=("camera", "scanner"),
        stated_as=ShippedSensorSpec | str | PackageSensorSpec,
    ),
]
