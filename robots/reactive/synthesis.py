"""Behaviour synthesis: competing utilitors become one motion (MACTA §3, eqs 1-3).

Normalised responses in [-1, 1] (table 2) stand for the angles [-pi/2, pi/2] of eq. 2 (our choice): then equal
utilities of opposite responses cancel, every resultant stays within the quarter turns, and rX is at most full
speed. Two utilitors half a turn apart would leave the resultant's sign to rounding.
"""

from cmath import phase, rect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, pi
from typing import NamedTuple

from robots.data import StrEnum

RESPONSE_RAD = pi / 2
"""The angle that a normalised response of 1 stands for."""

NO_UTILITY = 1e-9


class DegreeOfFreedom(StrEnum):
    """What is resolved separately; `grip` is our choice, the paper resolves translate and rotate."""

    TRANSLATE = "translate"
    ROTATE = "rotate"
    GRIP = "grip"

    __hash__ = str.__hash__  # Enum's own is written in Python, and slow


class Utilitor(NamedTuple):
    """A response (radians, (-pi, pi]) and how much it matters (utility, [0, 1])."""

    r: float
    u: float

    @classmethod
    def normalised(cls, response: float, utility: float) -> "Utilitor":
        """From a response in [-1, 1] and a utility in [0, 1], as table 2 gives them."""
        return cls(response * RESPONSE_RAD, utility)

    @property
    def response(self) -> float:
        """The response normalised to [-1, 1]; beyond a quarter turn it is clipped."""
        return max(-1.0, min(1.0, self.r / RESPONSE_RAD))


REST = Utilitor(0.0, 0.0)
"""No response, of no utility."""


def superpose(utilitors: Sequence[Utilitor]) -> Utilitor:
    """Resolve competing responses on one degree of freedom (MACTA §3, eqs 2-3).

    UX = sum(u_n * exp(j * r_n)); r = arg UX, u = |UX| / m.
    Our choice: UX = 0 gives (0, 0), no motion; the paper leaves arg 0 open.

    :param utilitors: m >= 1 pairs; r in radians (-pi, pi], u in [0, 1].
    :raises ValueError: if empty.
    """
    if not utilitors:
        raise ValueError("nothing to superpose: m must be at least 1")
    resultant = 0j
    for one in utilitors:
        resultant += rect(one.u, one.r)
    size = hypot(resultant.real, resultant.imag)
    if size < NO_UTILITY:
        return REST
    return Utilitor(phase(resultant), size / len(utilitors))


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """The command to the body. `close_gripper` None leaves the gripper as it is."""

    linear_m_s: float = 0.0
    angular_rad_s: float = 0.0
    close_gripper: bool | None = None


Resultants = Mapping[DegreeOfFreedom, Utilitor]


def synthesise(competing: Mapping[DegreeOfFreedom, Sequence[Utilitor]]) -> Resultants:
    """Resolve each degree of freedom on its own."""
    return {dof: superpose(utilitors) for dof, utilitors in competing.items() if utilitors}


def motion(resultant: Resultants, *, speed_m_s: float, turn_rad_s: float) -> Motion:
    """Scale the resultant responses to the body.

    A resultant response of pi/2 is full speed; a grip response above 0 closes, below 0 opens.
    """
    grip = resultant.get(DegreeOfFreedom.GRIP, REST)
    return Motion(
        linear_m_s=speed_m_s * resultant.get(DegreeOfFreedom.TRANSLATE, REST).response,
        angular_rad_s=turn_rad_s * resultant.get(DegreeOfFreedom.ROTATE, REST).response,
        close_gripper=grip.r > 0 if grip.u > 0 and grip.r != 0 else None,
    )
