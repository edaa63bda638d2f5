"""Obstacle avoidance: what the behaviour synthesis wants, made safe to drive. Interchangeable by a packet's data.

Each method is its settings, checked data, and a run of one packet that remembers (`Avoidance`). On-robot software only.
"""

from typing import Annotated

from pydantic import Field

from robots.avoidance.dynamic_window import DynamicWindow
from robots.avoidance.filtering import Filter
from robots.avoidance.surroundings import Surroundings
from robots.avoidance.vfh_plus import VfhPlus
from robots.avoidance.wanted import Avoidance, Velocity, Wanted

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
