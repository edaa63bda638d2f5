"""A robot with a body of its own, on the broker: own_robot.py mqtt://HOST own_robot.yaml carl (docs/runtime.md).

With a file as a further argument it keeps its memory there, and stands by: the world simulates the robot, whose mind
may be moved here and back.
"""

import sys
import time
from cmath import phase, rect
from math import inf, radians
from pathlib import Path

import numpy as np

from robots.contract.memory_file import MemoryFile
from robots.executive.agent import BehaviouralAgent
from robots.executive.robot_program import RobotProgram
from robots.link.mqtt import Broker, RobotLink
from robots.physical.body import GRIPPER_REACH_M, Gripper, Pose, Readings
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.physical.sightings import Sighting, Sightings
from robots.world import load_world


class OwnBody:
    """Moves as it is told, without motors: put yours, your sensors and your jaws here."""

    def __init__(self, start, beacons, samples, clock):
        self.at, self.heading = complex(start.x_m, start.y_m), start.heading_rad
        self.beacons, self.samples, self.clock = beacons, samples, clock
        self.moved_s, self.closed, self.held = clock.now_s(), False, None

    def set_velocity(self, linear_m_s, angular_rad_s):  # commanded with every tick
        now_s = self.clock.now_s()
        step_s, self.moved_s = min(now_s - self.moved_s, 0.2), now_s  # stands when it hears nothing
        self.heading += angular_rad_s * step_s
        self.at += rect(linear_m_s * step_s, self.heading)
        self.samples.update({self.held: self.jaws} if self.held else {})

    def set_gripper(self, *, closed):
        self.closed, self.held = closed, self.between if closed else None

    def get_position(self):
        return Pose(x_m=self.at.real, y_m=self.at.imag, heading_rad=phase(rect(1, self.heading)))

    def run_sensors(self, sensors): ...  # all of them run all the time

    def sense(self):
        seen = {**{n: b.point for n, b in self.beacons.items()}, **self.samples}
        seen.pop(self.held, None)
        return Readings(time_s=self.clock.now_s(), ranges_m=np.full(16, inf), bumper=False,
                        sightings=Sightings.of(self.sighting(*one) for one in seen.items()),
                        gripper=Gripper(closed=self.closed, between_jaws=self.between))  # fmt: skip

    def sighting(self, name, at):
        ray = (at - self.at) * rect(1, -self.heading)
        axes = self.beacons[name].approach_rad if name in self.beacons else ()
        aspects = [phase((self.at - at) * rect(1, -axis)) for axis in axes]
        return Sighting(
            identity=name,
            range_m=abs(ray),
            bearing_rad=phase(ray),
            aspect_rad=min(aspects, key=abs, default=0.0),
        )

    @property
    def jaws(self):
        return self.at + rect(GRIPPER_REACH_M, self.heading)

    @property
    def between(self):
        near = (name for name, at in self.samples.items() if abs(at - self.jaws) < 0.07)
        return self.held or next(near, None)


def main(url, file, name, memory=None):
    world = load_world(file)
    link = RobotLink(world.name, [name], Broker.at(url), stands_by=memory is not None)
    x_m, y_m, heading_deg = world.robot(name).start
    beacons = {
        p.name: BeaconSpec(x_m=p.at[0], y_m=p.at[1], approach_rad=tuple(map(radians, p.approach_deg)))
        for p in world.places
    }
    profile = RobotProfile(
        name=name, start=Pose(x_m=x_m, y_m=y_m, heading_rad=radians(heading_deg)), beacons=beacons
    )
    link.start()
    while not (link.run and link.clock.now_s()):
        time.sleep(0.1)  # until the world's run and time are announced
    body = OwnBody(profile.start, beacons, {s.name: beacons[s.at].point for s in world.samples}, link.clock)
    run = link.run

    def make(link_, kept):
        return BehaviouralAgent(profile=profile, body=body, link=link_, clock=link.clock, memory=kept)

    program = RobotProgram(
        name,
        make=make,
        link=link,
        clock=link.clock,
        store=None if memory is None else MemoryFile(Path(f"{memory}.{run}")),
        stands_by=memory is not None,
        seat=link,
    )
    while link.run == run:  # in another run of the world, start again
        program.tick()
        time.sleep(0.05)


if __name__ == "__main__":
    main(*sys.argv[1:])
