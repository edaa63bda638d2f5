"""Obstacle avoidance: what the behaviour synthesis wants, made safe to drive. Interchangeable by a packet's data.

Each method is its settings, checked data, and a run of one packet that remembers (`Avoidance`). On-robot software only.
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
