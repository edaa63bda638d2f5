"""Control loops: parallel sensing and acting (P-SMPA, algorithm 1), or sense, model, plan and act in sequence."""

from cmath import phase, rect
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import hypot
from typing import Protocol

import numpy as np

from robots.data import StrEnum
from robots.executive.executive import Executive
from robots.executive.sensing_plan import BehaviourState
from robots.perception.obstacles import Obstacles
from robots.perception.percepts import Percepts
from robots.perception.progress import Progress
from robots.perception.sensing import SensorAction
from robots.physical.geometry import to_robot, to_world, wrap
from robots.physical.profile import Architecture
from robots.physical.sightings import NONE_IN_VIEW, Sightings
from robots.reactive.synthesis import Motion

SENSE_S = 0.5
"""A sequential robot stands and senses for this long (our choice)."""
ACT_S = 1.0
"""It then acts for this long without sensing: at 0.5 m/s, with acceleration and braking, that is the half metre within
which P-SMPA's sonar detects obstacles.
"""
STANDS_M = 0.001
STANDS_RAD = 0.002
"""A robot that moves less than this in a tick stands."""


class ControlLoop(Protocol):
    """Updates the model and executes the plan, which the executive makes of a script in `accept`."""

    def update(self, sensed: Percepts) -> Percepts:
        """updateModel: the percepts to act on."""
        ...

    def execute(self, known: Percepts, step_s: float) -> Motion:
        """executePlans: S × P → A, one tick."""
        ...

    @property
    def beside(self) -> tuple[SensorAction, ...]:
        """The sensor actions to run until the next tick."""
        ...


class ParallelLoop:
    """P-SMPA: the sensor actions of the current state run all the time."""

    def __init__(self, executive: Executive) -> None:
        self._executive = executive

    def update(self, sensed: Percepts) -> Percepts:
        return sensed

    def execute(self, known: Percepts, step_s: float) -> Motion:
        return self._executive.step(known, step_s)

    @property
    def beside(self) -> tuple[SensorAction, ...]:
        behaviour = self._executive.behaviour
        return behaviour.beside if behaviour else ()


class Phase(StrEnum):
    """The phases of sequential SMPA."""

    SENSE = "sense"
    """Stand and read the sensors for `SENSE_S`."""
    MODEL = "model"
    """One tick."""
    PLAN = "plan"
    """One tick."""
    ACT = "act"
    """Act for up to `ACT_S`."""


class SequentialLoop:
    """SMPA: stands and senses what the current state needs, models, plans, and acts on that model.

    While the robot acts, odometry moves the model along. Acting ends early if the model lacks what the next action
    needs, or there is nothing to do.
    """

    def __init__(self, executive: Executive) -> None:
        self._executive = executive
        self._model: Percepts | None = None
        self._phase = Phase.SENSE
        self._stands = False
        self._since_s = 0.0

    def update(self, sensed: Percepts) -> Percepts:
        last = self._model
        model = sensed
        if last is not None:
            step = to_robot(last.odometry, complex(sensed.odometry.x_m, sensed.odometry.y_m))
            turned = wrap(sensed.odometry.heading_rad - last.odometry.heading_rad)
            self._stands = hypot(step.real, step.imag) < STANDS_M and abs(turned) < STANDS_RAD
            if self._phase is not Phase.SENSE:
                model = moved_by_odometry(last, sensed)
        self._model = model
        return model

    def execute(self, known: Percepts, step_s: float) -> Motion:
        behaviour = self._executive.behaviour
        if behaviour is None:
            self._enter(Phase.SENSE)
            return self._executive.step(known, step_s)
        informed = known.data.holds(behaviour.needs)
        self._since_s += step_s if informed else 0.0
        if self._phase is Phase.ACT:
            return self._act(behaviour, known, step_s)
        if self._phase is Phase.PLAN:
            self._enter(Phase.ACT)
        elif self._phase is Phase.MODEL:
            self._enter(Phase.PLAN)
        elif self._since_s >= SENSE_S:
            self._enter(Phase.MODEL)
        return Motion()

    @property
    def beside(self) -> tuple[SensorAction, ...]:
        behaviour = self._executive.behaviour
        return behaviour.beside if behaviour and self._stands and self._phase is Phase.SENSE else ()

    def _act(self, behaviour: BehaviourState, known: Percepts, step_s: float) -> Motion:
        motion = self._executive.step(known, step_s)
        informed = known.data.holds(behaviour.needs)
        idle = motion == Motion() and self._executive.behaviour is behaviour
        if informed and not idle and self._since_s < ACT_S:
            return motion
        self._enter(Phase.SENSE)
        return replace(motion, linear_m_s=0.0, angular_rad_s=0.0)

    def _enter(self, phase: Phase) -> None:
        self._phase = phase
        self._since_s = 0.0


LOOPS: Mapping[Architecture, Callable[[Executive], ControlLoop]] = {
    Architecture.PARALLEL: ParallelLoop,
    Architecture.SEQUENTIAL: SequentialLoop,
}


def moved_by_odometry(model: Percepts, now: Percepts) -> Percepts:
    """Earlier percepts as seen from the robot's present pose by dead reckoning."""

    def moved(known: Obstacles) -> Obstacles:
        at = [to_robot(now.pose, to_world(model.pose, one)) for one in known.at.tolist()]
        return Obstacles(np.array(at, dtype=np.complex128), known.radii_m, known.robots)

    turned = now.pose.heading_rad - model.pose.heading_rad
    seen = []
    for one in (model.seen or NONE_IN_VIEW).values():
        at = to_robot(now.pose, to_world(model.pose, rect(one.range_m, one.bearing_rad)))
        aspect = wrap(phase(at) - one.bearing_rad + turned + one.aspect_rad)
        seen.append(replace(one, range_m=abs(at), bearing_rad=phase(at), aspect_rad=aspect))
    return replace(
        model,
        time_s=now.time_s,
        pose=now.pose,
        odometry=now.odometry,
        battery=now.battery,
        charging=now.charging,
        progress=Progress(),
        seen=None if model.seen is None else Sightings.of(seen),
        solid=None if model.solid is None else moved(model.solid),
        about=None if model.about is None else moved(model.about),
    )
