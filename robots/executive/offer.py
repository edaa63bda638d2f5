"""A robot's bid for a leg of a plan, or why it makes none."""

from dataclasses import dataclass

from robots.data import StrEnum

DEFECT_S = 30.0
"""What each reading that is left out adds to the cost, in seconds (our choice)."""


class Declining(StrEnum):
    """Why a robot does not bid."""

    CANNOT = "cannot"
    """A packet is not in its repertoire, a place is not on its map, or it lacks a sensor."""
    FAULT = "fault"
    """It senses nothing that it could go by."""
    DEFECT = "defect"
    """It leaves out readings of a place or an object of the leg, or of its battery."""
    HOLDS = "holds"
    """It holds something else, and no script rids it of that."""
    BATTERY = "battery"
    """It would not take on the script, or not come to its end."""
    DRIVEN = "driven"
    """An operator drives it."""
    PAUSED = "paused"
    """Its script is paused: nobody knows when it is free."""


PASSING = (Declining.HOLDS, Declining.BATTERY, Declining.DRIVEN, Declining.PAUSED)
"""Reasons that may pass with what a robot, a mission or an operator does next."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Declined:
    """No bid. `words`: for people."""

    reason: Declining
    words: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Offer:
    """A bid.

    :param cost_s: what bids are compared by: release, way and work, the time to charge afterwards, and `DEFECT_S` for
        each reading that is left out.
    :param release_s: from now until the robot is free.
    :param way_s: from where it is then to the leg's first place, straight at full speed: a lower bound.
    :param work_s: of the leg's packets, as the call states them.
    :param battery: what is left after the leg, 0 to 1, all sensors on and the motors at full speed all the time: a
        lower bound.
    :param degraded: the readings that are left out.
    """

    cost_s: float
    release_s: float
    way_s: float
    work_s: float
    battery: float
    degraded: tuple[str, ...] = ()
