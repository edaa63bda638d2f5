"""A world that survives its process: if that dies, another one resumes from the snapshot."""

import logging
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from threading import Lock
from typing import Self

from robots.clock import Clock
from robots.link import LinkClosed
from robots.wire import Message
from robots.world import WorldFile
from sim.clock import WallClock
from sim.error import SimulationError
from sim.process.process import SimulationProcess
from sim.process.snapshot_file import SnapshotSettings
from sim.truth import Truth

MAX_DEATHS = 5
WITHIN_S = 120.0
"""A world whose process dies more often than `MAX_DEATHS` in this wall-clock time is given up."""

logger = logging.getLogger(__name__)

StartProcess = Callable[[SnapshotSettings], SimulationProcess]


class SupervisedWorld:
    """Implements `robots.link.Link` and `robots.clock.Clock` over one process after the other.

    `receive` notices that the process is gone and starts the next one; messages under way are lost. Meanwhile the clock
    stands still; it never goes back.
    """

    def __init__(
        self, start_process: StartProcess, snapshots: SnapshotSettings, wall_clock: Clock | None = None
    ) -> None:
        self._start_process = start_process
        self._wall_clock = wall_clock or WallClock()
        self._process = start_process(snapshots)
        self.run = self._process.run
        self.not_resumed_because = self._process.not_resumed_because
        self._resume = replace(snapshots, run=self.run, any_run=False, start_new=False, resume_only=True)
        self._deaths_at_s: deque[float] = deque(maxlen=MAX_DEATHS)
        self._lock = Lock()
        self._paused = False
        self._stopped = False

    @classmethod
    def start(
        cls, world: WorldFile, snapshots: SnapshotSettings, *, seed: int, speed: float, jitter_m: float
    ) -> Self:
        """:raises SimulationError: if it cannot be built; the message says why."""

        def start_process(settings: SnapshotSettings) -> SimulationProcess:
            return SimulationProcess.start(
                world, seed=seed, speed=speed, jitter_m=jitter_m, snapshots=settings
            )

        return cls(start_process, snapshots)

    @property
    def pid(self) -> int | None:
        """The present process."""
        return self._process.pid

    def now_s(self) -> float:
        return self._process.now_s()

    def truth(self) -> Truth:
        """The world as it is; never for an agent or the planner.

        :raises SimulationError: if no process runs just now.
        """
        return self._process.truth()

    def pause(self, paused: bool = True) -> None:
        """Pause the world, or let it continue; also applies to later processes."""
        with self._lock, suppress(SimulationError):
            self._paused = paused
            self._process.pause(paused)

    def send(self, message: Message) -> None:
        """A message to a process that is gone is lost: its sender repeats it."""
        with suppress(LinkClosed):
            self._process.link.send(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        """:raises LinkClosed: if the world was stopped, or cannot be resumed."""
        process = self._process
        try:
            return process.link.receive(timeout_s)
        except LinkClosed:
            self._replace(process)
            return ()

    def close(self) -> None:
        """Nothing to release: the link is the process's, which `stop` ends."""

    def stop(self) -> None:
        """End the process in order, and wait for its end; safe to call again."""
        with self._lock:
            self._stopped = True
            self._process.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _replace(self, gone: SimulationProcess) -> None:
        with self._lock:
            if self._stopped:
                raise LinkClosed("the world was stopped")
            if self._process is not gone:
                return
            gone.stop()
            self._count_death()
            try:
                process = self._start_process(self._resume)
                process.pause(self._paused)
            except SimulationError as error:
                logger.error("the world cannot be resumed: %s", error)
                raise LinkClosed(f"the world cannot be resumed: {error}") from error
            self._process = process
            logger.warning("the world's process died; process %s resumes from its snapshot", process.pid)

    def _count_death(self) -> None:
        now_s = self._wall_clock.now_s()
        if len(self._deaths_at_s) == MAX_DEATHS and now_s - self._deaths_at_s[0] < WITHIN_S:
            reason = f"the world's process died {MAX_DEATHS + 1} times in {WITHIN_S:.0f} s"
            logger.error("%s: the world is given up", reason)
            raise LinkClosed(reason)
        self._deaths_at_s.append(now_s)
