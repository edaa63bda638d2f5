"""A rover's battery: drained by what its parts draw, charged at the rover's home or another charger (our choice)."""

from robots.physical.energy import Powers

CHARGE_BELOW = 0.9
"""Charging begins below this level, as soon as the rover stands at a charger."""
CHARGED = 0.95
"""Charging ends at this level; the gap keeps it from toggling near full charge."""


class Battery:
    """The energy left, and whether it is being charged.

    An empty battery drives no motor. The electronics keep a reserve of their own that is not simulated (our choice),
    so that the rover can still report why it stands.
    """

    def __init__(self, powers: Powers, *, capacity_wh: float, level: float = 1.0) -> None:
        self._powers = powers
        self._full_j = capacity_wh * 3600
        self.left_j = level * self._full_j
        self.charging = False

    @property
    def level(self) -> float:
        """The share that is left, 0 to 1."""
        return self.left_j / self._full_j

    @property
    def needs_charge(self) -> bool:
        """True if it is charged at a charger."""
        return self.level < (CHARGED if self.charging else CHARGE_BELOW)

    def advance(
        self, step_s: float, *, running: frozenset[str], driven: tuple[float, float], at_charger: bool
    ) -> None:
        """Account for a step.

        :param driven: metres a second ahead, radians a second.
        """
        powers = self._powers
        self.charging = at_charger and self.needs_charge and driven == (0.0, 0.0)
        drawn_w = powers.electronics_w + powers.sensing_w(running) + powers.driving_w(*driven)
        drawn_w -= powers.charger_w if self.charging else 0.0
        self.left_j = min(self._full_j, max(0.0, self.left_j - drawn_w * step_s))
