"""Obstacle avoidance: interchangeable methods that make the motion of the behaviour synthesis safe.

Each method is an `AvoidanceMethod`, whose fields are its settings, as data of a packet, and makes an `Avoidance` that
keeps the state of one packet's run. Installed packages add methods (docs/packs.md).
"""

from typing import Annotated

from robots.data import ChosenBy
from robots.extensions import AVOIDANCES
from robots.reactive.avoidance.dynamic_window import DynamicWindow
from robots.reactive.avoidance.seam import Avoidance, AvoidanceMethod, Filter, Velocity, Wanted
from robots.reactive.avoidance.surroundings import Surroundings
from robots.reactive.avoidance.vfh_plus import VfhPlus

AnyAvoidance = Annotated[AvoidanceMethod, ChosenBy("by", AVOIDANCES)]

__all__ = [
    "AnyAvoidance",
    "Avoidance",
    "AvoidanceMethod",
    "DynamicWindow",
    "Filter",
    "Surroundings",
    "Velocity",
    "VfhPlus",
    "Wanted",
]
