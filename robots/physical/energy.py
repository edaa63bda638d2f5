"""The energy of sensing, and the saving by running only the sensors needed (P-SMPA §4.1: least commitment)."""

from functools import cache, cached_property
from importlib import resources

from pydantic import NonNegativeFloat, model_validator

from robots.data import Checked, read_yaml
from robots.physical.body import ALL_SENSORS, Sensor


class MotorPowers(Checked):
    """Watts a metre a second of driving, watts a radian a second of turning."""

    per_m_s: NonNegativeFloat
    per_rad_s: NonNegativeFloat


class Powers(Checked):
    """What a rover's parts draw, watts."""

    electronics_w: NonNegativeFloat
    charger_w: NonNegativeFloat
    motors: MotorPowers
    sensors: dict[Sensor, NonNegativeFloat]

    @model_validator(mode="after")
    def _complete(self) -> "Powers":
        if missing := ALL_SENSORS - self.sensors.keys():
            raise ValueError(f"sensors: the power is missing of {', '.join(sorted(missing))}")
        return self

    @cached_property
    def _sensing_w(self) -> dict[frozenset[str], float]:
        """By sensors that run, as far as they were asked for."""
        return {}

    def sensing_w(self, running: frozenset[str]) -> float:
        """What these sensors draw; added up once for each set of sensors."""
        known = self._sensing_w
        if running not in known:
            known[running] = sum(watts for sensor, watts in self.sensors.items() if sensor in running)
        return known[running]

    def driving_w(self, linear_m_s: float, angular_rad_s: float) -> float:
        return self.motors.per_m_s * abs(linear_m_s) + self.motors.per_rad_s * abs(angular_rad_s)


@cache
def load_powers() -> Powers:
    """The powers that ship with the robots' software."""
    text = resources.files("robots.physical").joinpath("powers.yaml").read_text(encoding="utf-8")
    return Powers.model_validate(read_yaml(text))


class SensingMeter:
    """Adds up the energy that running sensors use, and that those that are off would have used; joules."""

    def __init__(self, powers: Powers, *, used_j: float = 0.0, saved_j: float = 0.0) -> None:
        """:param used_j, saved_j: initial sums."""
        self._powers = powers
        self._all_w = powers.sensing_w(ALL_SENSORS)
        self.used_j = used_j
        self.saved_j = saved_j

    def count(self, running: frozenset[str], step_s: float) -> None:
        used_j = self._powers.sensing_w(running) * step_s
        self.used_j += used_j
        self.saved_j += self._all_w * step_s - used_j
