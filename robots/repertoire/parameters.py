"""Parameters of packets: checked values that a script may set (SRA fig. 4, in brackets)."""

from collections.abc import Mapping
from math import isfinite

from robots.data import Checked

Value = float | str


class Parameter(Checked):
    """A number within `least` and `most`, or one of `choices`."""

    about: str
    default: Value
    least: float = 0.0
    most: float = 0.0
    choices: tuple[str, ...] = ()

    def read(self, text: str) -> Value:
        """Parse and check a value.

        :raises ValueError: stating the valid values.
        """
        if self.choices:
            if text not in self.choices:
                raise ValueError(f"{text} is not one of {', '.join(self.choices)}")
            return text
        try:
            number = float(text)
        except ValueError:
            raise ValueError(f"{text!r} is not a number") from None
        if not (isfinite(number) and self.least <= number <= self.most):
            raise ValueError(f"{text} is not within {self.least:g} to {self.most:g}")
        return number


MAX_VELOCITY = "max_velocity_m_s"
MAX_DISTANCE = "max_distance_m"
LIMITS: Mapping[str, Parameter] = {
    MAX_VELOCITY: Parameter(about="no faster than this", default=2.0, least=0.01, most=2.0),
    MAX_DISTANCE: Parameter(about="no farther than this by odometry", default=1e4, least=0.01, most=1e4),
}
"""Parameters of every packet (SRA: of the base class Behaviour); the third, Timeout, is the packet's own field."""
