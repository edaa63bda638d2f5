"""What befalls the robots of `benchmarks.mishaps`, each in every part of an errand that it can befall."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import cos, nan, pi, sin

import numpy as np

from robots.body import Pose, Sensor
from robots.geometry import wrap
from sim.crew import Crew
from sim.mishaps import (
    Fault,
    Mishaps,
    beams_read,
    dead,
    frozen,
    has_room,
    knock,
    push,
    sees_nothing,
    sightings_read_nan,
)

ROBOT, SAMPLE, START, GOAL = "yard_1", "sample_1", "door_1", "interchange_2"
PASSES_S = 3.0
"""How long something passing lasts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """A running errand that something is done to."""

    crew: Crew
    mishaps: Mishaps
    rng: np.random.Generator

    @property
    def pose(self) -> Pose:
        return self.crew.simulation.scene.pose(ROBOT)


Act = Callable[[Stage], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Something done while a packet runs, `after_s` after its patterns began to act; perhaps undone later."""

    name: str
    during: str
    do: Act
    after_s: float = 1.0
    undo: Act | None = None
    undo_s: float = PASSES_S

    def __str__(self) -> str:
        return f"{self.name}, {self.during}"


ALL = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")


def turned(stage: Stage) -> None:
    """Turned by hand on the spot, by a quarter to a half turn."""
    pose = stage.pose
    turn = stage.rng.choice([-1, 1]) * stage.rng.uniform(pi / 2, pi)
    stage.mishaps.lift(stage.crew.simulation, ROBOT, replace(pose, heading_rad=wrap(pose.heading_rad + turn)))


def carried_off(stage: Stage) -> None:
    """Set down somewhere else, heading anywhere."""
    while True:
        x_m, y_m = stage.rng.uniform(0.4, 7.6), stage.rng.uniform(0.4, 3.2)
        pose = Pose(x_m=x_m, y_m=y_m, heading_rad=stage.rng.uniform(-pi, pi))
        if abs(complex(x_m - stage.pose.x_m, y_m - stage.pose.y_m)) > 1 and has_room(
            stage.crew.simulation, ROBOT, pose
        ):
            stage.mishaps.lift(stage.crew.simulation, ROBOT, pose)
            return


def shoved(stage: Stage) -> None:
    """Pushed over the floor, 0.3 to 0.6 m in some direction."""
    for _ in range(100):
        by_m, way = stage.rng.uniform(0.3, 0.6), stage.rng.uniform(-pi, pi)
        try:
            push(stage.crew.simulation, ROBOT, ahead_m=by_m * cos(way), left_m=by_m * sin(way))
        except ValueError:
            continue
        return


def knocked(by_m: float) -> Act:
    """The sample rolls off over the floor of the yard, so that no wall hides it."""

    def act(stage: Stage) -> None:
        truth = stage.crew.simulation.truth().samples[SAMPLE]
        while True:
            way = stage.rng.uniform(-pi, pi)
            point = (truth.x_m + by_m * cos(way), truth.y_m + by_m * sin(way))
            if 0.15 < point[0] < 7.85 and 0.15 < point[1] < 3.45:
                break
        stage.crew.simulation.drop(SAMPLE)
        knock(stage.crew.simulation, SAMPLE, point)

    return act


def hidden(identity: str) -> Act:
    return lambda stage: stage.mishaps.hide(identity)


def shown(identity: str) -> Act:
    return lambda stage: stage.mishaps.show(identity)


def boxed(at: tuple[float, float], side_m: float) -> Act:
    """A tall box is put somewhere."""

    def act(stage: Stage) -> None:
        stage.crew.simulation.scene.put_box(at, 0.0, side_m=side_m, height_m=0.6)

    return act


def sensor(fault: Callable[[], Fault]) -> Act:
    return lambda stage: stage.mishaps.break_sensor(ROBOT, fault())


def mended(stage: Stage) -> None:
    stage.mishaps.mend(ROBOT)
    stage.mishaps.bodies[ROBOT].wheel_fault = None


def wheels_nan(stage: Stage) -> None:
    stage.mishaps.bodies[ROBOT].wheel_fault = lambda pose: replace(pose, x_m=nan, heading_rad=nan)


def wheels_frozen(stage: Stage) -> None:
    body = stage.mishaps.bodies[ROBOT]
    kept = body.get_position()
    body.wheel_fault = lambda _: kept


def battery_nan(stage: Stage) -> None:
    stage.mishaps.break_sensor(ROBOT, lambda readings: replace(readings, battery=nan))


WHISKER_FAULTS: dict[str, Callable[[], Fault]] = {
    "one whisker NaN": lambda: beams_read(nan, 1),
    "one whisker reads 0": lambda: beams_read(0.0, 1),
    "whiskers NaN": lambda: beams_read(nan),
    "whiskers dead": lambda: dead(Sensor.ULTRASONIC),
    "whiskers frozen": lambda: frozen(Sensor.ULTRASONIC),
}
SENSOR_FAULTS: dict[str, Callable[[], Fault]] = {
    "infra-red NaN": lambda: sightings_read_nan,
    "infra-red dead": lambda: dead(Sensor.INFRA_RED),
    "infra-red frozen": lambda: frozen(Sensor.INFRA_RED),
    "infra-red covered": lambda: sees_nothing,
    "gripper dead": lambda: dead(Sensor.GRIPPER),
    "gripper frozen": lambda: frozen(Sensor.GRIPPER),
}


def cases() -> Iterator[Case]:
    """All of them."""
    for tag in ALL:
        place = START if tag in ("NAVIGATE", "DOCK") else GOAL
        yield Case(name="turned by hand", during=tag, do=turned)
        yield Case(name="carried off", during=tag, do=carried_off)
        yield Case(name="pushed", during=tag, do=shoved)
        yield Case(name="beacon hidden 10 s", during=tag, do=hidden(place), undo=shown(place), undo_s=10)
        yield Case(name="beacon hidden for good", during=tag, do=hidden(place))
        yield Case(
            name="all covered 10 s", during=tag, do=sensor(lambda: sees_nothing), undo=mended, undo_s=10
        )
        yield from _sensors(tag)
    for tag in ("NAVIGATE", "DOCK"):
        yield Case(name="sample knocked 0.15 m", during=tag, do=knocked(0.15))
        yield Case(name="sample knocked 1 m", during=tag, do=knocked(1.0))
        yield Case(name="sample hidden 3 s", during=tag, do=hidden(SAMPLE), undo=shown(SAMPLE))
    yield Case(name="sample knocked from jaws", during="TRANSPORT", after_s=3.0, do=knocked(0.5))
    yield Case(name="sample knocked from jaws", during="RELEASE2", after_s=0.5, do=knocked(0.5))
    hatch, before = (6.0, 3.6), (6.0, 2.9)
    yield Case(name="box in the hatch", during="TRANSPORT", do=boxed(hatch, 0.36))
    yield Case(name="box in the hatch", during="RELEASE2", after_s=0.2, do=boxed(hatch, 0.36))
    yield Case(name="box at the approach point", during="TRANSPORT", do=boxed(before, 0.4))
    yield Case(name="box on the way", during="TRANSPORT", do=boxed((4.0, 2.2), 0.5))
    yield Case(name="box at the approach point", during="NAVIGATE", after_s=0.2, do=boxed((2.0, 1.5), 0.3))


def _sensors(tag: str) -> Iterator[Case]:
    """Whiskers do not run while a robot docks or deposits."""
    whiskers = WHISKER_FAULTS if tag in ("NAVIGATE", "TRANSPORT") else {}
    for name, fault in {**whiskers, **SENSOR_FAULTS}.items():
        yield Case(name=name, during=tag, do=sensor(fault))
    yield Case(name="odometry NaN", during=tag, do=wheels_nan)
    yield Case(name="odometry frozen", during=tag, do=wheels_frozen)
    yield Case(name="battery NaN", during=tag, do=battery_nan)
    yield Case(name="infra-red NaN 3 s", during=tag, do=sensor(lambda: sightings_read_nan), undo=mended)
