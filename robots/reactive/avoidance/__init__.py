"""Obstacle avoidance: interchangeable methods that make the motion of the behaviour synthesis safe.

Each method has its settings, as data of a packet, and an `Avoidance` that keeps the state of one packet's run.
"""

from typing import Annotated

from pydantic import Field

from robots.reactive.avoidance.dynamic_window import DynamicWindow
from robots.reactive.avoidance.seam import Avoidance, Filter, Velocity, Wanted
from robots.reactive.avoidance.surroundings import Surroundings
from robots.reactive.avoidance.vfh_plus import VfhPlus

AnyAvoidance = Annotated[VfhPlus | DynamicWindow, Field(discriminator="by")]

__all__ = [
    "AnyAvoidance",
    "Avoidance",
    "DynamicWindow",
    "Filter",
    "Surroundings",
    "Velocity",
    "VfhPlus",
    "Wanted",
]
