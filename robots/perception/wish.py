"""What an operator who drives a robot wishes of it at this moment."""

from typing import NamedTuple


class Wish(NamedTuple):
    """In [-1, 1]: `forward`, negative: back, a share of the speed that a driven robot may have; `left`, to turn, one of
    the rate at which it can.
    """

    forward: float = 0.0
    left: float = 0.0

    @property
    def moves(self) -> bool:
        return self != (0.0, 0.0)
