"""A world's snapshot: everything it takes to go on from an instant, as data that JSON holds. No pickle.

World frame, metres, radians; points that the simulation keeps as complex numbers are pairs here. What is derived from
the world file (walls, beacons, sensors) is not in it, nor is what the physics engine makes anew each tick.
"""

from collections.abc import Mapping
from hashlib import sha256
from json import dumps
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from robots.executive.memory import RobotMemory
from robots.physical.body import Pose, Sensor
from robots.world import WorldFile

FORMAT: Final = 1
"""Raised when a snapshot of before cannot be resumed any more."""

Pair = tuple[float, float]


class State(BaseModel):
    """Part of a snapshot: immutable, and unknown fields are an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class StreamState(State):
    """Where a stream of random numbers (PCG64) stands."""

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


class OdometryState(State):
    """Dead reckoning with its constant errors; `last` is the true pose it has accounted for."""

    estimate: Pose
    last: Pose
    scale: float
    turn_scale: float


class RampedState(State):
    """The drive of a body that takes up the velocity it is told."""

    kind: Literal["ramped"] = "ramped"
    driven: Pair
    odometry: OdometryState


class EncoderState(State):
    """A wheeled body's counters, and how far its measures are off."""

    grip: Pair
    believed_base_m: float
    rolled_m: Pair
    counted: tuple[int, int]
    pose: Pose


class AxleState(State):
    """The wheels: rim speeds, motors' set speeds, slip, and what the floor pulled in the last tick."""

    rims_m_s: Pair
    set_m_s: Pair
    slip: Pair
    pulled_n_s: Pair


class WheeledState(State):
    """The drive of a body on wheels; `last` is its true pose a tick ago."""

    kind: Literal["wheeled"] = "wheeled"
    encoders: EncoderState
    axle: AxleState
    last: Pose
    floor: StreamState


class BodyState(State):
    """A rover's body: the command it holds, the sensors that run, its battery and its drive."""

    wanted: Pair
    running: frozenset[Sensor]
    left_j: float
    charging: bool
    drive: Annotated[RampedState | WheeledState, Field(discriminator="kind")]


class GripState(State):
    """One capture head on a long object."""

    end: int
    middle: Pair
    heading_rad: float
    square_rad: float


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
    """Where a sample is, held or not."""

    point: Pair
    heading_rad: float


class RockState(State):
    """Where an obstacle was drawn to stand."""

    point: Pair
    radius_m: float


class WorldSnapshot(State):
    """A world at a tick of its clock. `told`: what each robot was told of its start; `robots`: their flash memories."""

    format: Literal[1] = FORMAT
    run: str
    digest: str
    seed: int
    ticks: int
    rovers: dict[str, Pose]
    told: dict[str, Pose]
    samples: dict[str, SampleState]
    rocks: tuple[RockState, ...]
    jaws: JawsState
    bodies: dict[str, BodyState]
    streams: dict[str, StreamState]
    touched: frozenset[str]
    robots: dict[str, RobotMemory]


def digest_of(world: WorldFile) -> str:
    """Says whether two world files describe the same world; what a file leaves out does not count."""
    said = world.model_dump(mode="json", exclude_defaults=True)
    return sha256(dumps(said, sort_keys=True).encode()).hexdigest()
