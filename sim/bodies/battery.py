"""A rover's battery: goes down by what its parts draw, and is charged at the rover's home (our choice)."""

from robots.body import Sensor
from robots.sensing.energy import Powers

CHARGE_BELOW, CHARGED = 0.25, 0.95
"""Charging begins below the one and ends at the other, so that a rover is not for ever about to be full."""


class Battery:
    """Holds what is left.

    An empty one drives no motor. The electronics keep a reserve of their own that is not simulated (our choice), so
    that the rover can still say why it stands there.
    """

    def __init__(self, powers: Powers, *, level: float = 1.0) -> None:
        self._powers = powers
        self._full_j = powers.capacity_wh * 3600
        self._left_j = level * self._full_j
        self.charging = False

    @property
    def level(self) -> float:
        """The share that is left, 0 to 1."""
        return self._left_j / self._full_j

    @property
    def left_j(self) -> float:
        return self._left_j

    def recall(self, left_j: float, *, charging: bool) -> None:
        """Go on with what was left."""
        self._left_j, self.charging = left_j, charging

    def pass_time(
        self, step_s: float, *, running: frozenset[Sensor], driven: tuple[float, float], at_home: bool
    ) -> None:
        """Account for a step.

        :param driven: metres a second ahead, radians a second.
        """
        powers = self._powers
        wanted = self.level < (CHARGED if self.charging else CHARGE_BELOW)
        self.charging = at_home and wanted and driven == (0.0, 0.0)
        drawn_w = powers.electronics_w + powers.sensing_w(running) + powers.driving_w(*driven)
        drawn_w -= powers.charger_w if self.charging else 0.0
        self._left_j = min(self._full_j, max(0.0, self._left_j - drawn_w * step_s))
