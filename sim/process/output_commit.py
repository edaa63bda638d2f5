"""Output commit: nothing that robots say leaves before the snapshot that contains that it was said is on the disk.

So whoever hears of something from a world will find it so in the world that goes on from its snapshot. Telemetry is
exempt: nobody builds on it.
"""

import logging
from collections.abc import Callable

from sim.process.snapshot_file import SnapshotFile
from sim.world.simulation import Simulation

EVERY_S = 1.0
"""A world in which nobody says anything is kept this often; all in wall-clock seconds."""
SHARE = 0.1
"""Of the time that snapshots may take; what is said meanwhile leaves with the next one."""

logger = logging.getLogger(__name__)


class OutputCommit:
    """Takes the snapshots of a world whose hub holds back what robots say."""

    def __init__(self, simulation: Simulation, file: SnapshotFile, wall_s: Callable[[], float]) -> None:
        self._simulation, self._file, self._wall_s = simulation, file, wall_s
        self._not_before_s = self._at_last_s = wall_s()
        self._failed = False

    def consider(self) -> None:
        """Between two ticks: take a snapshot if something waits for it, or the last one is old."""
        now_s = self._wall_s()
        if now_s >= self._at_last_s or (self._simulation.hub.holding and now_s >= self._not_before_s):
            self.take()

    def take(self) -> None:
        """Take a snapshot, then let go of what was said so far. If the disk refuses, robots' letters wait."""
        began_s = self._wall_s()
        try:
            self._file.write(self._simulation.snapshot())
        except OSError as error:
            if not self._failed:
                logger.error("cannot keep world %s: %s; its robots' letters wait", self._name, error)
            self._failed = True
            self._not_before_s = self._at_last_s = began_s + EVERY_S
            return
        self._failed = False
        self._simulation.hub.release()
        self._simulation.hub.flush(self._simulation.clock.now_s())
        done_s = self._wall_s()
        self._not_before_s = done_s + (done_s - began_s) * (1 / SHARE - 1)
        self._at_last_s = max(began_s + EVERY_S, self._not_before_s)

    @property
    def _name(self) -> str:
        return self._simulation.world.name
