"""Two driven wheels on an axle through the body's middle: motors, inertia, traction.

Our choices: impulses per tick instead of forces, so that any dimensions are stable; a wheel that does not slip takes
the chassis with it, one whose traction is used up slips; sideways slip is braked by the whole traction. Speeds of
wheels are those of their rims, metres a second; left is 0, right is 1.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from robots.world.bodies import WheeledBodySpec
from sim.clock import TICK_S
from sim.physics.scene import ROVER_INERTIA_KG_M2, ROVER_MASS_KG
from sim.snapshot import AxleState

GRAVITY_M_S2 = 9.81
ON_WHEELS = 0.8
"""Share of the weight that the driven wheels bear; the caster, which rolls in any direction, bears the rest."""
STANDS_M_S = 1e-3
"""A wheel commanded to stand and slower than this is held by its brake."""

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Velocity:
    """Of the chassis in its own frame: ahead and to the left, metres a second; turn, radians a second."""

    ahead_m_s: float = 0.0
    left_m_s: float = 0.0
    turn_rad_s: float = 0.0


STILL = Velocity()


class Axle:
    """The wheels' own state: rim speeds, and the speeds to which the motors are set."""

    def __init__(self, spec: WheeledBodySpec, grip: Pair = (1.0, 1.0)) -> None:
        """:param grip: true radius of each wheel as a share of the nominal one."""
        self._spec = spec
        self.grip = grip
        self.state = AxleState()
        per_turn = ROVER_INERTIA_KG_M2 / spec.base_m**2
        self._wheel_kg = spec.inertia_kg_m2 / spec.radius_m**2
        self._own_kg = ROVER_MASS_KG / 4 + per_turn  # effective chassis mass at a wheel that is pulled alone
        self._cross_kg = ROVER_MASS_KG / 4 - per_turn  # and at the other wheel
        load_n = ROVER_MASS_KG * GRAVITY_M_S2 * ON_WHEELS
        self._torque_n_s = spec.torque_n_m / spec.radius_m * TICK_S
        self._traction_n_s = spec.traction * load_n / 2 * TICK_S

    def follow(self, now: Velocity) -> Velocity:
        """Let the wheels follow a chassis that was stopped or pushed, as far as they do not slip.

        :param now: the chassis' velocity in the last tick, with all collisions.
        """
        spare = _each(lambda used, limit: limit - abs(used), self.state.pulled_n_s, (self._traction_n_s,) * 2)
        return self._pull(now, self.state.rims_m_s, self.state.slip, spare)

    def roll(self, now: Velocity, linear_m_s: float, angular_rad_s: float, slip: Pair) -> Velocity:
        """The chassis' velocity for the coming tick, by motors and floor.

        :param slip: share of each wheel's turn that is lost on the floor in this tick.
        """
        self.state.slip = slip
        self.state.set_m_s = self._ramped(self._wanted(linear_m_s, angular_rad_s))
        if self.state.set_m_s == (0.0, 0.0) and self._stands(now):
            self.state.rims_m_s = (0.0, 0.0)
            self.state.pulled_n_s = (0.0, 0.0)
            return STILL
        motors = self._motors(self._over_ground(now))
        spun = _each(lambda rim, push: rim + push / self._wheel_kg, self.state.rims_m_s, motors)
        pulled = self._pull(now, spun, slip, (self._traction_n_s,) * 2)
        held_n_s = _within(-ROVER_MASS_KG * now.left_m_s, 2 * self._traction_n_s)
        return replace(pulled, left_m_s=now.left_m_s + held_n_s / ROVER_MASS_KG)

    def _pull(self, now: Velocity, spun: Pair, slip: Pair, limits: Pair) -> Velocity:
        """Chassis and wheels after traction has acted between them; updates the wheels."""
        pull = self._traction(spun, self._over_ground(now), slip, limits)
        self.state.pulled_n_s = pull
        self.state.rims_m_s = _each(lambda rim, back: rim - back / self._wheel_kg, spun, pull)
        turn_n_m_s = (pull[1] - pull[0]) * self._spec.base_m / 2
        return Velocity(
            now.ahead_m_s + (pull[0] + pull[1]) / ROVER_MASS_KG,
            now.left_m_s,
            now.turn_rad_s + turn_n_m_s / ROVER_INERTIA_KG_M2,
        )

    def _over_ground(self, now: Velocity) -> Pair:
        """Speed of the floor below each wheel."""
        across = now.turn_rad_s * self._spec.base_m / 2
        return (now.ahead_m_s - across, now.ahead_m_s + across)

    def _wanted(self, linear_m_s: float, angular_rad_s: float) -> Pair:
        """Rim speeds for a velocity; beyond the wheels' limit both are slowed, so that the curve stays the same."""
        across = angular_rad_s * self._spec.base_m / 2
        left = linear_m_s - across
        right = linear_m_s + across
        limit_m_s = self._spec.speed_rad_s * self._spec.radius_m
        share = min(1.0, limit_m_s / max(abs(left), abs(right), 1e-9))
        return (left * share * self.grip[0], right * share * self.grip[1])

    def _ramped(self, wanted: Pair) -> Pair:
        step_m_s = self._spec.acceleration_rad_s2 * self._spec.radius_m * TICK_S
        return _each(lambda was, then: was + _within(then - was, step_m_s), self.state.set_m_s, wanted)

    def _motors(self, over_ground: Pair) -> Pair:
        """Impulses at the rims that bring the wheels to their set speeds, within the motors' torque.

        A motor turns its wheel, and through it as much of the chassis as traction allows.
        """
        left = (1 - self.state.slip[0]) * self.state.set_m_s[0] - over_ground[0]
        right = (1 - self.state.slip[1]) * self.state.set_m_s[1] - over_ground[1]
        own = self._own_kg
        cross = self._cross_kg
        limit = self._traction_n_s
        load = (_within(own * left + cross * right, limit), _within(cross * left + own * right, limit))
        spin = _each(lambda then, now: self._wheel_kg * (then - now), self.state.set_m_s, self.state.rims_m_s)
        return _each(lambda own, loaded: _within(own + loaded, self._torque_n_s), spin, load)

    def _traction(self, spun: Pair, over_ground: Pair, slip: Pair, limits: Pair) -> Pair:
        """Impulses between floor and wheels that end their slipping, within the limits."""
        lag = (
            (1 - slip[0]) * spun[0] - over_ground[0],
            (1 - slip[1]) * spun[1] - over_ground[1],
        )
        give = 1 / ROVER_MASS_KG + self._spec.base_m**2 / (4 * ROVER_INERTIA_KG_M2)
        cross = 1 / ROVER_MASS_KG - self._spec.base_m**2 / (4 * ROVER_INERTIA_KG_M2)
        own = (give + (1 - slip[0]) / self._wheel_kg, give + (1 - slip[1]) / self._wheel_kg)
        scale = own[0] * own[1] - cross * cross
        wished = ((lag[0] * own[1] - lag[1] * cross) / scale, (lag[1] * own[0] - lag[0] * cross) / scale)
        left, right = _each(_within, wished, limits)
        if left != wished[0]:  # a slipping wheel changes the load of the other
            right = _within((lag[1] - cross * left) / own[1], limits[1])
        elif right != wished[1]:
            left = _within((lag[0] - cross * right) / own[0], limits[0])
        return (left, right)

    def _stands(self, now: Velocity) -> bool:
        speeds = (*self.state.rims_m_s, now.ahead_m_s, now.left_m_s, now.turn_rad_s * self._spec.base_m)
        return all(abs(speed) < STANDS_M_S for speed in speeds)


def _each(change: Callable[[float, float], float], one: Pair, other: Pair) -> Pair:
    return (change(one[0], other[0]), change(one[1], other[1]))


def _within(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
