"""Percepts made by hand."""

from collections.abc import Iterable
from math import inf, pi

import numpy as np

from robots.perception.fusion import Perception
from robots.perception.percepts import Percepts
from robots.perception.sensing import MutualDataStore
from robots.physical.body import Gripper, Pose, Readings
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.physical.sightings import Sighting, Sightings

PROFILE = RobotProfile(
    name="me",
    start=Pose(x_m=0, y_m=0, heading_rad=0),
    beacons={"bay": BeaconSpec(x_m=2, y_m=0, approach_rad=(pi,))},
    others=("other",),
    lengths_m={"beam": 0.9},
)


def readings(
    *sightings: Sighting,
    whiskers: dict[int, float] | None = None,
    closed: bool = False,
    between: str | None = None,
    head: tuple[float, float] = (0.0, 0.0),
    battery: float = 1.0,
) -> Readings:
    ranges = np.full(16, inf)
    for beam, range_m in (whiskers or {}).items():
        ranges[beam] = range_m
    return Readings(
        time_s=0,
        ranges_m=ranges,
        bumper=False,
        sightings=Sightings.of(sightings),
        gripper=Gripper(closed=closed, between_jaws=between),
        capture_head_m=head,
        battery=battery,
    )


def sees(identity: str, range_m: float, bearing_rad: float = 0.0, aspect_rad: float = 0.0) -> Sighting:
    return Sighting(identity=identity, range_m=range_m, bearing_rad=bearing_rad, aspect_rad=aspect_rad)


def percepts(*sightings: Sighting, for_s: float = 1.0, **others: object) -> Percepts:
    """What a robot at the origin perceives when it has sensed the same for a while."""
    return watch([readings(*sightings, **others)] * (int(for_s / 0.05) + 1))  # type: ignore[arg-type]


def watch(instants: Iterable[Readings]) -> Percepts:
    """The percepts after sensing one instant after the other, 0.05 s apart."""
    perception = Perception(PROFILE)
    for tick, instant in enumerate(instants):
        data = MutualDataStore(instant.by_sensor())
        here = Pose(x_m=0, y_m=0, heading_rad=0)
        last = perception.perceive(data, here, tick * 0.05, battery=instant.battery)
    return last
