"""A world and the link to its robots, as passed to the composition root."""

from collections.abc import Callable
from dataclasses import dataclass

from app.agents import RobotBoard
from robots.clock import Clock
from robots.link import Link
from robots.link.mqtt.fleet import ANNOUNCE_INTERVAL_S
from robots.link.transport import ServiceEnd
from robots.world import WorldFile

FLAT_OUT = 200.0
"""Assumed maximum rate of a world that runs as fast as possible, world seconds per wall-clock second (our choice)."""


def _nothing() -> None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningWorld:
    """A world whose robots are reached over `link`, in the time of `clock`.

    :param rate: world seconds per wall-clock second; None: as fast as possible.
    :param run: the id of the world's run, kept when it is resumed; None if `fleet` reports it.
    :param fleet: the link to the process that drives the world, if that starts and ends by itself.
    :param new_run_reason: why a new run was started, if an earlier one might have been resumed.
    :param resume: called once the service receives messages; a simulated world is paused until then.
    """

    file: WorldFile
    link: Link
    clock: Clock
    rate: float | None = 1.0
    run: str | None
    new_run_reason: str = ""
    resume: Callable[[], None] = _nothing
    fleet: ServiceEnd | None = None

    def lag_s(self) -> float:
        """World seconds by which `clock` may be behind the world's own clock."""
        if self.fleet is None:
            return 0.0
        pace = self.pace()
        return ANNOUNCE_INTERVAL_S * (FLAT_OUT if pace is None else pace)

    def pace(self) -> float | None:
        """The current rate."""
        return self.rate if self.fleet is None else self.fleet.clock.rate

    def listen(self, board: RobotBoard) -> None:
        """Start to receive from the fleet, if there is one; contact and telemetry go to the board."""
        if self.fleet is not None:
            self.fleet.listen(board)
            self.fleet.start()
