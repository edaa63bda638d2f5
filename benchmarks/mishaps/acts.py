"""Mishaps of a robot at work, of the sample it works on, or of a beacon."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, nan, pi, sin

import numpy as np

from benchmarks.mishaps.injection import (
    Fault,
    FaultInjector,
    beams_read,
    dead,
    frozen,
    sees_nothing,
    sightings_read_nan,
)
from robots.physical.body import RADIUS_M, Pose, Sensor
from robots.physical.geometry import wrap
from sim.trials.mishaps import has_room, push
from sim.world.simulation import Simulation


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """An undertaking under way, and its robot that has the mishap."""

    simulation: Simulation
    faults: FaultInjector
    rng: np.random.Generator
    robot: str
    sample: str

    @property
    def pose(self) -> Pose:
        return self.simulation.scene.pose(self.robot)


Act = Callable[[Stage], None]


def turned(stage: Stage) -> None:
    """Turned by hand on the spot, by a quarter to a half turn."""
    pose = stage.pose
    turn = stage.rng.choice([-1, 1]) * stage.rng.uniform(pi / 2, pi)
    stage.faults.lift(stage.simulation, stage.robot, replace(pose, heading_rad=wrap(pose.heading_rad + turn)))


def carried_off(stage: Stage) -> None:
    """Set down somewhere else, heading anywhere."""
    while True:
        x_m, y_m = stage.rng.uniform(0.4, 7.6), stage.rng.uniform(0.4, 3.2)
        pose = Pose(x_m=x_m, y_m=y_m, heading_rad=stage.rng.uniform(-pi, pi))
        if abs(complex(x_m - stage.pose.x_m, y_m - stage.pose.y_m)) > 1 and has_room(
            stage.simulation, stage.robot, pose
        ):
            stage.faults.lift(stage.simulation, stage.robot, pose)
            return


def shoved(stage: Stage) -> None:
    """Pushed over the floor, 0.3 to 0.6 m in some direction."""
    for _ in range(100):
        by_m, way = stage.rng.uniform(0.3, 0.6), stage.rng.uniform(-pi, pi)
        try:
            push(stage.simulation, stage.robot, ahead_m=by_m * cos(way), left_m=by_m * sin(way))
        except ValueError:
            continue
        return


def knocked(by_m: float) -> Act:
    """The sample rolls off over the floor of the robot's compartment, so that no wall hides it."""

    def act(stage: Stage) -> None:
        simulation = stage.simulation
        truth = simulation.truth().samples[stage.sample]
        room = simulation.world.area_of(simulation.world.robot(stage.robot))
        while True:
            way = stage.rng.uniform(-pi, pi)
            point = (truth.x_m + by_m * cos(way), truth.y_m + by_m * sin(way))
            if all(
                low + 0.15 < at < high - 0.15 for at, (low, high) in zip(point, (room.x, room.y), strict=True)
            ):
                break
        simulation.drop(stage.sample)
        simulation.scene.set_down(stage.sample, point)

    return act


def put(point: tuple[float, float], sample: str = "") -> Act:
    """A sample, by default the one that the robot works on, is moved to a point."""

    def act(stage: Stage) -> None:
        stage.simulation.drop(sample or stage.sample)
        stage.simulation.scene.set_down(sample or stage.sample, point)

    return act


def switched_off(stage: Stage) -> None:
    stage.faults.switch(stage.robot, on=False)


def switched_on(stage: Stage) -> None:
    stage.faults.switch(stage.robot, on=True)


def jaws_fail(stage: Stage) -> None:
    """They stay as they are, open or closed."""
    stage.faults.bodies[stage.robot].jaws_fail = True


def jaws_mended(stage: Stage) -> None:
    stage.faults.bodies[stage.robot].jaws_fail = False


def twisted(turn_rad: float) -> Act:
    """Turned by hand on the spot, by an angle to a random side."""

    def act(stage: Stage) -> None:
        turned_rad = stage.pose.heading_rad + stage.rng.choice([-1, 1]) * turn_rad
        lifted = replace(stage.pose, heading_rad=wrap(turned_rad))
        stage.faults.lift(stage.simulation, stage.robot, lifted)

    return act


def nudged(ahead_m: float, left_m: float) -> Act:
    """Pushed over the floor a little, to a random side."""

    def act(stage: Stage) -> None:
        side = stage.rng.choice([-1, 1])
        push(stage.simulation, stage.robot, ahead_m=side * ahead_m, left_m=side * left_m)

    return act


def release(stage: Stage) -> None:
    """Its jaws open and stay open."""
    body = stage.faults.bodies[stage.robot]
    body.set_gripper(closed=False)


def hidden(identity: str) -> Act:
    return lambda stage: stage.faults.hide(identity)


def shown(identity: str) -> Act:
    return lambda stage: stage.faults.show(identity)


def boxed(at: tuple[float, float], side_m: float) -> Act:
    """A tall box is put somewhere."""

    def act(stage: Stage) -> None:
        stage.simulation.scene.put_box(at, 0.0, side_m=side_m, height_m=0.6)

    return act


def walled_in(stage: Stage) -> None:
    """Four boxes are put round the robot, 0.1 m from its hull."""
    pose, side_m = stage.pose, 0.3
    off_m = RADIUS_M + 0.1 + side_m / 2
    for number in range(4):
        way = pose.heading_rad + number * pi / 2
        at = (pose.x_m + off_m * cos(way), pose.y_m + off_m * sin(way))
        stage.simulation.scene.put_box(at, way, side_m=side_m, height_m=0.6)


def sensor(fault: Callable[[], Fault]) -> Act:
    return lambda stage: stage.faults.break_sensor(stage.robot, fault())


def mended(stage: Stage) -> None:
    stage.faults.mend(stage.robot)
    stage.faults.bodies[stage.robot].wheel_fault = None


def wheels_nan(stage: Stage) -> None:
    stage.faults.bodies[stage.robot].wheel_fault = lambda pose: replace(pose, x_m=nan, heading_rad=nan)


def wheels_frozen(stage: Stage) -> None:
    body = stage.faults.bodies[stage.robot]
    kept = body.get_position()
    body.wheel_fault = lambda _: kept


def battery_nan(stage: Stage) -> None:
    stage.faults.break_sensor(stage.robot, lambda readings: replace(readings, battery=nan))


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
