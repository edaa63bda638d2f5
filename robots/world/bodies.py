"""A robot's body in a world file: its kind alone (`body: wheeled`), or its kind with parameters to override."""

from typing import Annotated, ClassVar, Literal, get_args

from pydantic import Field

from robots.data import Checked, StrEnum
from robots.extensions import BODIES
from robots.world.package_parts import PackagePartSpec, PartOfPackage

Kind = Literal["velocity", "wheeled", "avatar"]


class BodyKind(StrEnum):
    """What a robot's body is (SRA: real, simulated and virtual robots)."""

    VIRTUAL = "virtual"
    """An avatar: in the simulation, without physics."""
    SIMULATED = "simulated"
    """In the simulation, moved by its physics."""
    REAL = "real"
    """With software of its own, outside of the simulation."""


class Ramps(Checked):
    """The accelerations of a body without wheels."""

    is_solid: ClassVar[bool] = True
    """Whether it bears real objects."""

    acceleration_m_s2: float = Field(default=1.0, gt=0, le=20)
    turn_acceleration_rad_s2: float = Field(default=6.0, gt=0, le=100)


class VelocityBodySpec(Ramps):
    """Takes on the commanded velocity within its accelerations, unless it is blocked."""

    kind: Literal["velocity"] = "velocity"


class AvatarBodySpec(Ramps):
    """A virtual robot: no physical body; others pass through it, and it stops at walls by checking the map."""

    kind: Literal["avatar"] = "avatar"
    is_solid: ClassVar[bool] = False


class WheeledBodySpec(Checked):
    """Two driven wheels on one axle through the body's middle, and a caster that bears the rest of its weight.

    `base_m` lies between the wheels; speed, acceleration and torque are a wheel's own. `traction` is the
    friction coefficient of wheel on floor, `slip` the standard deviation of the share of a wheel's turn that is lost or
    gained in a tick of 1/60 s. `counts`: of the encoder, per turn of a wheel.
    """

    kind: Literal["wheeled"] = "wheeled"
    is_solid: ClassVar[bool] = True
    base_m: float = Field(default=0.36, ge=0.1, le=0.44)
    radius_m: float = Field(default=0.07, ge=0.02, le=0.2)
    speed_rad_s: float = Field(default=14.0, gt=0, le=200)
    acceleration_rad_s2: float = Field(default=15.0, gt=0, le=1000)
    torque_n_m: float = Field(default=2.5, gt=0, le=100)
    inertia_kg_m2: float = Field(default=0.004, gt=0, le=1)
    traction: float = Field(default=0.7, gt=0, le=2)
    slip: float = Field(default=0.02, ge=0, le=0.5)
    counts: int = Field(default=2000, ge=16, le=100_000)

    def check_speeds(self, robot: str, *, linear_m_s: float, angular_rad_s: float) -> None:
        """:raises ValueError: if the wheels cannot reach the robot's speed or turn rate."""
        rim_m_s = self.speed_rad_s * self.radius_m
        if rim_m_s < linear_m_s:
            raise ValueError(
                f"{robot}.speed_m_s is {linear_m_s}, but its wheels of {self.radius_m} m at {self.speed_rad_s} rad/s "
                f"reach {rim_m_s:.2f} m/s: lower it, or raise body.speed_rad_s or body.radius_m"
            )
        if rim_m_s < angular_rad_s * self.base_m / 2:
            raise ValueError(
                f"{robot}.turn_rad_s is {angular_rad_s}, but its wheels, {self.base_m} m apart, turn it at "
                f"{2 * rim_m_s / self.base_m:.2f} rad/s: lower it, or raise body.speed_rad_s or body.radius_m"
            )


class PackageBodySpec(PackagePartSpec):
    """A body of an installed package: a subclass, registered as `macta.bodies` under its kind, adds its parameters.

    The simulation makes the body with the subclass's `make_body` (`sim.bodies.factory.MakesBody`). One that is virtual
    says so: `is_solid: ClassVar[bool] = False`.
    """

    is_solid: ClassVar[bool] = True

    def check_speeds(self, robot: str, *, linear_m_s: float, angular_rad_s: float) -> None:
        """:raises ValueError: if the body cannot reach the robot's speed or turn rate."""


ShippedBodySpec = Annotated[VelocityBodySpec | WheeledBodySpec | AvatarBodySpec, Field(discriminator="kind")]

BodySpec = Annotated[
    VelocityBodySpec | WheeledBodySpec | AvatarBodySpec | PackageBodySpec,
    PartOfPackage(
        group=BODIES,
        base=PackageBodySpec,
        shipped=ShippedBodySpec,
        kinds=get_args(Kind),
        stated_as=Kind | ShippedBodySpec | str | PackageBodySpec,
    ),
]


def kind_of(body: BodySpec, *, external: bool) -> BodyKind:
    """What a robot's body is. `external`: software of its own speaks for the robot."""
    if external:
        return BodyKind.REAL
    return BodyKind.SIMULATED if body.is_solid else BodyKind.VIRTUAL
