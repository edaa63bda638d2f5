"""A long object on the capture heads of one or two rovers: a rigid body in the plane (MACTA §5).

A capture head is "3 DOF passive compliant": a spring and damper in x and y between the jaws' middle and the object's
handle, and in torsion about the gripper's vertical axis, where the jaws slip on the object ("gripper slip"). The
constants are our choice. A handle beyond the head's travel is out of the jaws. What a head exerts on the object acts on
its rover, too (`load`), so that each robot's motion is transmitted to the other and back.

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
TORSION_DAMPING_N_M_S_RAD = 3.0
MAX_TORQUE_N_M = 4.0
"""Above this torque the jaws slip round on the handle."""
DENSITY_KG_M = 2.0
CONTACT_N_M = 5000.0
CONTACT_DAMPING_N_S_M = 60.0
SUBSTEPS = 8


@dataclass(frozen=True, slots=True)
class JawsPose:
    """The middle of a rover's jaws, and the direction they point in."""

    middle: complex
    heading_rad: float


@dataclass(frozen=True, slots=True)
class Contact:
    """A solid body overlaps the object: where, along which unit normal, how deep."""

    at: complex
    normal: complex
    depth_m: float


@dataclass(frozen=True, slots=True)
class Load:
    """What an object exerts on a rover at its jaws: newtons ahead and (imaginary) to its left, and newton metres."""

    force_n: complex = 0j
    torque_n_m: float = 0.0


UNLOADED = Load()


@dataclass(slots=True)
class Grip:
    """One capture head at one end (+1 or -1) of the object. `square_rad`: the object's torque-free turn in it.

    `load`: the mean over the last tick.
    """

    end: int
    jaws: JawsPose
    square_rad: float
    load: Load = UNLOADED


class Beam:
    """The object's motion: `middle`, `heading_rad` of its length, and their rates."""

    def __init__(self, length_m: float, middle: complex, heading_rad: float) -> None:
        self.length_m = length_m
        self.middle = middle
        self.heading_rad = heading_rad
        self._velocity = 0j
        self._turn_rate = 0.0
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
                    force_n=_pair(grip.load.force_n),
                    torque_n_m=grip.load.torque_n_m,
                )
                for rover, grip in self._grips.items()
            },
        )

    def restore(self, state: BeamState) -> None:
        self.middle = complex(*state.middle)
        self.heading_rad = state.heading_rad
        self._velocity = complex(*state.velocity)
        self._turn_rate = state.turn_rate
        self._grips = {
            rover: Grip(
                grip.end,
                JawsPose(complex(*grip.middle), grip.heading_rad),
                grip.square_rad,
                Load(complex(*grip.force_n), grip.torque_n_m),
            )
            for rover, grip in state.grips.items()
        }

    def handle(self, end: int) -> complex:
        """The position of the handle at an end."""
        return self.middle + self._arm(end)

    def grip(self, rover: str, end: int, jaws: JawsPose) -> None:
        """The head grips the handle, without torque at the present angle."""
        self._grips[rover] = Grip(end, jaws, self.heading_rad - jaws.heading_rad)

    def release(self, rover: str) -> None:
        """Open the head; when the last one opens, the object is at rest."""
        self._grips.pop(rover)
        if not self._grips:
            self._velocity = 0j
            self._turn_rate = 0.0

    def end_of(self, rover: str) -> int:
        return self._grips[rover].end

    def deflection(self, rover: str) -> complex:
        """The handle's position relative to the jaws' middle, in the rover's own frame."""
        grip = self._grips[rover]
        return (self.handle(grip.end) - grip.jaws.middle) * rect(1.0, -grip.jaws.heading_rad)

    def load(self, rover: str) -> Load:
        """What the object exerted on the rover in the last tick."""
        return self._grips[rover].load

    def advance(self, jaws: Mapping[str, JawsPose], contacts: Iterable[Contact], step_s: float) -> list[str]:
        """Advance by one tick in which the jaws moved to `jaws`; returns the rovers that have lost their handle."""
        before = {rover: grip.jaws for rover, grip in self._grips.items()}
        rates = {rover: _rate(before[rover], jaws[rover], step_s) for rover in self._grips}
        fixed = tuple(contacts)
        for grip in self._grips.values():
            grip.load = UNLOADED
        for part in range(1, SUBSTEPS + 1):
            for rover, grip in self._grips.items():
                grip.jaws = _interpolated(before[rover], jaws[rover], part / SUBSTEPS)
            self._substep(rates, fixed, step_s / SUBSTEPS)
        return [rover for rover in self._grips if abs(self.deflection(rover)) > TRAVEL_M]

    def _substep(
        self, rates: Mapping[str, tuple[complex, float]], contacts: tuple[Contact, ...], step_s: float
    ) -> None:
        force = 0j
        torque = 0.0
        for rover, grip in self._grips.items():
            arm = self._arm(grip.end)
            pull = self._pull(grip, rates[rover][0])
            twist = self._twist(grip, rates[rover][1])
            force += pull
            torque += _cross(arm, pull) + twist
            here = grip.load
            grip.load = Load(
                here.force_n - pull * rect(1.0, -grip.jaws.heading_rad) / SUBSTEPS,
                here.torque_n_m - twist / SUBSTEPS,
            )
        for contact in contacts:
            push = self._push(contact)
            force += push
            torque += _cross(contact.at - self.middle, push)
        self._velocity += force / self._mass_kg * step_s
        self._turn_rate += torque / self._inertia * step_s
        self.middle += self._velocity * step_s
        self.heading_rad = remainder(self.heading_rad + self._turn_rate * step_s, tau)

    def _pull(self, grip: Grip, velocity: complex) -> complex:
        """The spring and damper in x and y."""
        stretch = self.handle(grip.end) - grip.jaws.middle
        return -STIFFNESS_N_M * stretch - DAMPING_N_S_M * (self._speed_at(self._arm(grip.end)) - velocity)

    def _twist(self, grip: Grip, turn_rate: float) -> float:
        """The spring and damper in torsion; torque beyond the limit turns the jaws on the handle."""
        offset_rad = remainder(self.heading_rad - grip.jaws.heading_rad - grip.square_rad, tau)
        max_rad = MAX_TORQUE_N_M / TORSION_N_M_RAD
        held_rad = max(-max_rad, min(max_rad, offset_rad))
        grip.square_rad += offset_rad - held_rad
        torque = -TORSION_N_M_RAD * held_rad - TORSION_DAMPING_N_M_S_RAD * (self._turn_rate - turn_rate)
        return max(-MAX_TORQUE_N_M, min(MAX_TORQUE_N_M, torque))

    def _push(self, contact: Contact) -> complex:
        approach_m_s = _dot(self._speed_at(contact.at - self.middle), contact.normal)
        return max(0.0, CONTACT_N_M * contact.depth_m - CONTACT_DAMPING_N_S_M * approach_m_s) * contact.normal

    def _arm(self, end: int) -> complex:
        return end * rect(self.length_m / 2, self.heading_rad)

    def _speed_at(self, arm: complex) -> complex:
        return self._velocity + 1j * self._turn_rate * arm


def _interpolated(before: JawsPose, now: JawsPose, share: float) -> JawsPose:
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
