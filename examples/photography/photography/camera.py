from cmath import phase
from dataclasses import dataclass, replace
from math import dist, tanh
from typing import Literal

from robots.conditions.verdict import Condition, Verdict
from robots.perception.percepts import LOCATING, Percepts
from robots.physical.body import Readings
from robots.reactive.responses import Response
from robots.world.bodies import PackageBodySpec, Ramps
from robots.world.sensors import PackageSensorSpec
from sim.bodies.factory import BodyParts, SensorSite
from sim.bodies.velocity import VelocityBody


class Soft(Response):
    def at(self, s: float) -> float:
        return tanh(2 * s)


class Framed(Condition, needs=LOCATING):
    target: str
    least_lx: float

    def check(self, percepts: Percepts) -> Verdict:
        at = percepts.locate(self.target) or 0j
        light_lx = percepts.measured.get("light_lx", 0.0)
        holds = at != 0 and abs(phase(at)) <= 0.05 and light_lx >= self.least_lx
        return Verdict(holds, f"has {self.target} {phase(at):+.2f} rad off centre in {light_lx:.0f} lx")


class DollySpec(PackageBodySpec):
    kind: Literal["dolly"] = "dolly"

    def make_body(self, parts: BodyParts) -> VelocityBody:
        return VelocityBody(parts.spec, Ramps(acceleration_m_s2=0.5), parts.jaws, parts.scene, parts.odometry)


@dataclass
class LightMeter:
    site: SensorSite
    lamp: tuple[float, float]

    def process(self, readings: Readings) -> Readings:
        pose = self.site.pose()
        light_lx = 1000 / (1 + dist((pose.x_m, pose.y_m), self.lamp) ** 2)
        return replace(readings, measured={**readings.measured, "light_lx": light_lx})


class LightMeterSpec(PackageSensorSpec):
    kind: Literal["light_meter"] = "light_meter"
    lamp: tuple[float, float]

    def make_sensor(self, site: SensorSite) -> LightMeter:
        return LightMeter(site, self.lamp)
