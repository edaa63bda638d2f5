"""What one sensor tells of things at one instant: SRA's Observation(object_name, sensor_modality, ...)."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class Modality(StrEnum):
    """Through which sense something is perceived."""

    INFRA_RED = "infra_red"
    ULTRASONIC = "ultrasonic"
    TOUCH = "touch"

    __hash__ = str.__hash__  # as of sensors, to be looked up quickly


WEIGHT = {Modality.INFRA_RED: 0.3, Modality.ULTRASONIC: 0.1, Modality.TOUCH: 0.5}
"""How much of what is missing to certainty one observation adds (our choice)."""
SIGMA_M = {Modality.INFRA_RED: 0.05, Modality.ULTRASONIC: 0.1, Modality.TOUCH: 0.15}
"""How far the place it tells may be off, metres (our choice)."""


@dataclass(frozen=True, slots=True)
class Observation:
    """Things by name, and where each is.

    :param at: shape (N,), complex, world frame, metres.
    """

    names: tuple[str, ...]
    modality: Modality
    at: NDArray[np.complex128]

    @classmethod
    def of_one(cls, name: str, modality: Modality, at: complex) -> "Observation":
        return cls((name,), modality, np.array([at], dtype=np.complex128))
