"""A world as the composition root is given it."""

from collections.abc import Callable
from dataclasses import dataclass

from app.agents import RobotBoard
from robots.clock import Clock
from robots.link import Link
from robots.link.mqtt import ServiceLink
from robots.world import WorldFile


def _nothing() -> None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningWorld:
    """A world whose robots can be reached: over `link`, in the time of `clock`.

    :param rate: world seconds a wall-clock second, None flat out.
    :param run: names the world from its building on, however often it is resumed; None if `fleet` says so.
    :param fleet: what drives the robots, if it comes and goes by itself; `link` and `clock` are its then.
    :param why_afresh: why it was built, if one that was there before might have gone on.
    :param let_go: called once somebody listens: a world that stands still until then misses no deadline.
    """

    file: WorldFile
    link: Link
    clock: Clock
    rate: float | None = 1.0
    run: str | None
    why_afresh: str = ""
    let_go: Callable[[], None] = _nothing
    fleet: ServiceLink | None = None

    def pace(self) -> float | None:
        """Its rate now."""
        return self.rate if self.fleet is None else self.fleet.clock.rate

    def listen(self, board: RobotBoard) -> None:
        """Begin to hear the fleet, if it comes and goes by itself; what it says of its robots is for the board."""
        if self.fleet is not None:
            self.fleet.listen(board)
            self.fleet.start()
