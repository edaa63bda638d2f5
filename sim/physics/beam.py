"""A long object on the capture heads of one or two rovers: a rigid body in the plane (MACTA §5).

A capture head is "3 DOF passive compliant": a spring and damper in x and y between the jaws' middle and the object's
handle, and in torsion about the gripper's vertical axis, where the jaws slip on the object ("gripper slip"). Measures
are our choice. Beyond its travel the handle is out of the jaws. Rovers do not feel the force: they are velocity-set.

Units: metres, newtons, kilograms, radians, seconds; points are complex in the world's frame.
"""

from cmath import rect
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import remainder, tau

from sim.snapshot import BeamState, GripState

STIFFNESS_N_M = 200.0
DAMPING_N_S_M = 20.0
TRAVEL_M = 0.06
TORSION_N_M_RAD = 40.0
TORSION_DAMPING = 3.0
"""Newton metres a radian a second."""
SLIP_N_M = 4.0
"""Above this torque the jaws slip round on the handle."""
DENSITY_KG_M = 2.0
CONTACT_N_M = 5000.0
CONTACT_DAMPING_N_S_M = 60.0
SUBSTEPS = 8


@dataclass(frozen=True, slots=True)
class JawsPose:
    """Where a rover's jaws are: their middle, and the direction they point in."""

    middle: complex
    heading_rad: float


@dataclass(frozen=True, slots=True)
class Press:
    """Something solid presses against the object: where, along which unit normal, how deep, metres."""

    at: complex
    normal: complex
    depth_m: float


@dataclass(slots=True)
class Grip:
    """One capture head at one end (+1 or -1) of the object. `square_rad`: how the object is turned in it without
    torque.
    """

    end: int
    jaws: JawsPose
    square_rad: float


class Beam:
    """The object's motion: `middle`, `heading_rad` of its length, and their rates."""

    def __init__(self, length_m: float, middle: complex, heading_rad: float) -> None:
        self.length_m = length_m
        self.middle, self.heading_rad = middle, heading_rad
        self._velocity, self._turn_rate = 0j, 0.0
        self._mass_kg = DENSITY_KG_M * length_m
        self._inertia = self._mass_kg * length_m**2 / 12
        self._grips: dict[str, Grip] = {}

    def state(self) -> BeamState:
        return BeamState(
            middle=_pair(self.middle),
            heading_rad=self.heading_rad,
            velocity=_pair(self._velocity),
            turn_rate=self._turn_rate,
            grips={
                rover: GripState(
                    end=grip.end,
                    middle=_pair(grip.jaws.middle),
                    heading_rad=grip.jaws.heading_rad,
                    square_rad=grip.square_rad,
                )
                for rover, grip in self._grips.items()
            },
        )

    def recall(self, state: BeamState) -> None:
        """Go on moving in the heads that have it."""
        self.middle, self.heading_rad = complex(*state.middle), state.heading_rad
        self._velocity, self._turn_rate = complex(*state.velocity), state.turn_rate
        self._grips = {
            rover: Grip(one.end, JawsPose(complex(*one.middle), one.heading_rad), one.square_rad)
            for rover, one in state.grips.items()
        }

    def handle(self, end: int) -> complex:
        """Where the handle at an end is."""
        return self.middle + self._arm(end)

    def grip(self, rover: str, end: int, jaws: JawsPose) -> None:
        """The head takes the handle as it is turned."""
        self._grips[rover] = Grip(end, jaws, self.heading_rad - jaws.heading_rad)

    def let_go(self, rover: str) -> None:
        """The head is off; the last one leaves the object at rest."""
        self._grips.pop(rover)
        if not self._grips:
            self._velocity, self._turn_rate = 0j, 0.0

    def end_of(self, rover: str) -> int:
        return self._grips[rover].end

    def deflection(self, rover: str) -> complex:
        """The handle's place relative to the jaws' middle, in the rover's own frame."""
        grip = self._grips[rover]
        return (self.handle(grip.end) - grip.jaws.middle) * rect(1.0, -grip.jaws.heading_rad)

    def advance(self, jaws: Mapping[str, JawsPose], presses: Iterable[Press], step_s: float) -> list[str]:
        """Move on by one tick in which the jaws came to where they are now; who has lost its handle by then."""
        before = {rover: grip.jaws for rover, grip in self._grips.items()}
        rates = {rover: _rate(before[rover], jaws[rover], step_s) for rover in self._grips}
        pressed = tuple(presses)
        for part in range(1, SUBSTEPS + 1):
            for rover, grip in self._grips.items():
                grip.jaws = _on_the_way(before[rover], jaws[rover], part / SUBSTEPS)
            self._substep(rates, pressed, step_s / SUBSTEPS)
        return [rover for rover in self._grips if abs(self.deflection(rover)) > TRAVEL_M]

    def _substep(
        self, rates: Mapping[str, tuple[complex, float]], presses: tuple[Press, ...], step_s: float
    ) -> None:
        force, torque = 0j, 0.0
        for rover, grip in self._grips.items():
            arm = self._arm(grip.end)
            pull = self._pull(grip, rates[rover][0])
            force += pull
            torque += _cross(arm, pull) + self._twist(grip, rates[rover][1])
        for press in presses:
            push = self._push(press)
            force += push
            torque += _cross(press.at - self.middle, push)
        self._velocity += force / self._mass_kg * step_s
        self._turn_rate += torque / self._inertia * step_s
        self.middle += self._velocity * step_s
        self.heading_rad = remainder(self.heading_rad + self._turn_rate * step_s, tau)

    def _pull(self, grip: Grip, velocity: complex) -> complex:
        """The spring and damper in x and y."""
        stretch = self.handle(grip.end) - grip.jaws.middle
        return -STIFFNESS_N_M * stretch - DAMPING_N_S_M * (self._speed_at(self._arm(grip.end)) - velocity)

    def _twist(self, grip: Grip, turn_rate: float) -> float:
        """The spring and damper in torsion; what is beyond the slip torque turns the jaws on the handle."""
        off_rad = remainder(self.heading_rad - grip.jaws.heading_rad - grip.square_rad, tau)
        most_rad = SLIP_N_M / TORSION_N_M_RAD
        held_rad = max(-most_rad, min(most_rad, off_rad))
        grip.square_rad += off_rad - held_rad
        torque = -TORSION_N_M_RAD * held_rad - TORSION_DAMPING * (self._turn_rate - turn_rate)
        return max(-SLIP_N_M, min(SLIP_N_M, torque))

    def _push(self, press: Press) -> complex:
        into = _dot(self._speed_at(press.at - self.middle), press.normal)
        return max(0.0, CONTACT_N_M * press.depth_m - CONTACT_DAMPING_N_S_M * into) * press.normal

    def _arm(self, end: int) -> complex:
        return end * rect(self.length_m / 2, self.heading_rad)

    def _speed_at(self, arm: complex) -> complex:
        return self._velocity + 1j * self._turn_rate * arm


def _on_the_way(before: JawsPose, now: JawsPose, share: float) -> JawsPose:
    turned = remainder(now.heading_rad - before.heading_rad, tau)
    middle = before.middle + share * (now.middle - before.middle)
    return JawsPose(middle, before.heading_rad + share * turned)


def _rate(before: JawsPose, now: JawsPose, step_s: float) -> tuple[complex, float]:
    turned = remainder(now.heading_rad - before.heading_rad, tau)
    return (now.middle - before.middle) / step_s, turned / step_s


def _pair(point: complex) -> tuple[float, float]:
    return (point.real, point.imag)


def _cross(one: complex, other: complex) -> float:
    return one.real * other.imag - one.imag * other.real


def _dot(one: complex, other: complex) -> float:
    return one.real * other.real + one.imag * other.imag
