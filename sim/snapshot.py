"""A world's snapshot: everything needed to resume it, as JSON data.

World frame, metres, radians; complex numbers of the simulation are pairs here. It contains neither what is derived from
the world file (walls, beacons, sensors) nor what the physics engine computes again each tick.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from robots.executive.memory import RobotMemory
from robots.physical.body import Pose

FORMAT: Final = 1
"""Increased when earlier snapshots can no longer be resumed."""

Pair = tuple[float, float]
Named = TypeVar("Named")


CONFIG = ConfigDict(extra="forbid", allow_inf_nan=False)


class State(BaseModel):
    """Part of a snapshot: immutable, and unknown fields are an error."""

    model_config = ConfigDict(**CONFIG, frozen=True)


class StreamState(State):
    """State of a stream of random numbers (PCG64)."""

    state: int
    inc: int
    has_uint32: int
    uinteger: int

    @classmethod
    def of(cls, rng: np.random.Generator) -> "StreamState":
        kept: Mapping[str, Any] = rng.bit_generator.state
        return cls(**kept["state"], has_uint32=kept["has_uint32"], uinteger=kept["uinteger"])

    def restore(self, rng: np.random.Generator) -> None:
        rng.bit_generator.state = {
            "bit_generator": "PCG64",
            "state": {"state": self.state, "inc": self.inc},
            "has_uint32": self.has_uint32,
            "uinteger": self.uinteger,
        }


@dataclass(slots=True, kw_only=True)
class OdometryState:
    """Dead reckoning with its constant errors; `last` is the true pose it has accounted for."""

    __pydantic_config__ = CONFIG

    estimate: Pose
    last: Pose
    scale: float
    turn_scale: float


class RampedState(State):
    """The drive of a body without wheels."""

    kind: Literal["ramped"] = "ramped"
    driven: Pair
    odometry: OdometryState

    @property
    def reckoned(self) -> Pose:
        """Where odometry believes it to be."""
        return self.odometry.estimate


@dataclass(slots=True, kw_only=True)
class EncoderState:
    """A wheeled body's counters, the errors of its dimensions, and the pose it reckons with."""

    __pydantic_config__ = CONFIG

    grip: Pair
    """True radius of each wheel as a share of the nominal one."""
    believed_base_m: float
    rolled_m: Pair
    counted: tuple[int, int]
    pose: Pose


@dataclass(slots=True, kw_only=True)
class AxleState:
    """The wheels: rim speeds, motors' set speeds, slip, and what the floor pulled in the last tick."""

    __pydantic_config__ = CONFIG

    rims_m_s: Pair = (0.0, 0.0)
    set_m_s: Pair = (0.0, 0.0)
    slip: Pair = (0.0, 0.0)
    pulled_n_s: Pair = (0.0, 0.0)


class WheeledState(State):
    """The drive of a body on wheels; `last` is its true pose a tick ago."""

    kind: Literal["wheeled"] = "wheeled"
    encoders: EncoderState
    axle: AxleState
    last: Pose
    floor: StreamState

    @property
    def reckoned(self) -> Pose:
        """Where odometry believes it to be."""
        return self.encoders.pose


class BodyState(State):
    """A rover's body: its command (`wanted`), the sensors that run, its battery and its drive."""

    wanted: Pair
    running: frozenset[str]
    left_j: float
    charging: bool
    drive: Annotated[RampedState | WheeledState, Field(discriminator="kind")]


class GripState(State):
    """One capture head on a long object, and what that exerted on the rover in the last tick."""

    end: int
    middle: Pair
    heading_rad: float
    square_rad: float
    force_n: Pair = (0.0, 0.0)
    torque_n_m: float = 0.0


class BeamState(State):
    """A long object on capture heads, by rover."""

    middle: Pair
    heading_rad: float
    velocity: Pair
    turn_rate: float
    grips: dict[str, GripState]


class JawsState(State):
    """All grippers; `holders` of each sample, the one that carries it first."""

    closed: dict[str, bool]
    holders: dict[str, tuple[str, ...]]
    beams: dict[str, BeamState]
    slipped: int


class SampleState(State):
    """A sample's pose, held or not, and how it rolls."""

    point: Pair
    heading_rad: float
    velocity_m_s: Pair = (0.0, 0.0)


class PeripheralState(State):
    """A door, hatch or lift. `shares`: how far each of its panels is raised; `at`, `wanted`: the states that it is in,
    or comes from, and goes to; `rides_s`: how long a lift has been on its way; `fault`: as `sim.world.mechanisms` has
    it; `memory`: of its software, JSON.
    """

    shares: tuple[float, ...]
    at: str
    wanted: str
    rides_s: float
    fault: str
    memory: str


@dataclass(frozen=True, slots=True)
class Rock:
    """A round obstacle, as drawn: its middle and radius."""

    __pydantic_config__ = CONFIG

    point: Pair
    radius_m: float


class ForeignSnapshot(State):
    """What robots that are not simulated have told: their poses, and where each sample is that they have moved.

    `moved`: a place or a robot, and the time of that.
    """

    version: int = 0
    robots: dict[str, Pose] = {}
    moved: dict[str, tuple[str, float]] = {}
    carried: dict[str, str] = {}
    """Sample to the robot that holds it."""


class WorldSnapshot(State):
    """A world at a tick of its clock. `told`: the start poses the robots were told; `robots`: their memories.

    `digest` is of the world's file; `document` the changed world of a later `edition` as JSON, empty for edition 0;
    `delivered`: the deliveries that were made.
    """

    format: Literal[1] = FORMAT
    run: str
    digest: str
    edition: int = 0
    document: str = ""
    delivered: frozenset[str] = frozenset()
    seed: int
    ticks: int
    rovers: dict[str, Pose]
    told: dict[str, Pose]
    samples: dict[str, SampleState]
    rocks: tuple[Rock, ...]
    jaws: JawsState
    bodies: dict[str, BodyState]
    streams: dict[str, StreamState]
    touched: frozenset[str]
    robots: dict[str, RobotMemory]
    peripherals: dict[str, PeripheralState] = Field(default_factory=dict)
    foreign: ForeignSnapshot = ForeignSnapshot()

    @property
    def reckoned(self) -> dict[str, Pose]:
        """Where each rover's odometry believes it to be."""
        return {name: body.drive.reckoned for name, body in self.bodies.items()}

    def only(self, *, robots: Collection[str], samples: Collection[str]) -> "WorldSnapshot":
        """Without what no longer belongs to the world. A sample whose holder goes is left where it is."""
        beams = {
            sample: beam.model_copy(update={"grips": kept})
            for sample, beam in self.jaws.beams.items()
            if sample in samples and (kept := _of(beam.grips, robots))
        }
        holders = {
            sample: tuple(robot for robot in holding if robot in robots)
            for sample, holding in self.jaws.holders.items()
            if sample in samples
        }
        return self.model_copy(
            update={
                "rovers": _of(self.rovers, robots),
                "told": _of(self.told, robots),
                "samples": _of(self.samples, samples),
                "jaws": self.jaws.model_copy(
                    update={"closed": _of(self.jaws.closed, robots), "holders": holders, "beams": beams}
                ),
                "bodies": _of(self.bodies, robots),
                "streams": _of(self.streams, robots),
                "touched": self.touched.intersection(robots),
                "robots": _of(self.robots, robots),
            }
        )


def _of(known: Mapping[str, Named], names: Collection[str]) -> dict[str, Named]:
    return {name: value for name, value in known.items() if name in names}
