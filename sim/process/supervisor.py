"""A world that outlives its process: if that dies, another one goes on from the snapshot."""

import logging
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from threading import Lock
from typing import Self

from robots.link import LinkClosed
from robots.wire import Message
from robots.world import WorldFile
from sim.error import SimulationError
from sim.process.keep import Keep
from sim.process.process import SimulationProcess
from sim.truth import Truth

MOST, WITHIN_S = 5, 120.0
"""A world whose process dies more often than this, in wall-clock seconds, is given up."""

logger = logging.getLogger(__name__)

Start = Callable[[Keep], SimulationProcess]


class LastingWorld:
    """Implements `robots.link.channel.Link` and `robots.clock.Clock` over one process after the other.

    Whoever listens on the link notices that the process is gone and begins the next one; what was in the air is lost.
    The clock stands still meanwhile, and does not go back.
    """

    def __init__(self, start: Start, keep: Keep, wall_s: Callable[[], float] = time.monotonic) -> None:
        """:param start: begins a process of the world, as it is kept."""
        self._start, self._wall_s = start, wall_s
        self._process = start(keep)
        self.run, self.why_afresh = self._process.run, self._process.why_afresh
        self._keep = replace(keep, run=self.run, any_run=False, afresh=False, resume_only=True)
        self._deaths: deque[float] = deque(maxlen=MOST)
        self._lock = Lock()
        self._paused = self._stopped = False

    @classmethod
    def start(cls, world: WorldFile, keep: Keep, *, seed: int, speed: float, jitter_m: float) -> Self:
        """:raises SimulationError: if it cannot be built; the message says why."""
        return cls(
            lambda kept: SimulationProcess.start(world, seed=seed, speed=speed, jitter_m=jitter_m, keep=kept),
            keep,
        )

    @property
    def pid(self) -> int | None:
        """The present process."""
        return self._process.pid

    def now_s(self) -> float:
        return self._process.now_s()

    def truth(self) -> Truth:
        """The world as it is; never for an agent or the planner.

        :raises SimulationError: if there is no process to ask just now.
        """
        return self._process.truth()

    def pause(self, paused: bool = True) -> None:
        """Let the world stand still, or go on. A process that is to come is told when it comes."""
        with self._lock, suppress(SimulationError):
            self._paused = paused
            self._process.pause(paused)

    def send(self, message: Message) -> None:
        """To a process that is gone nothing is sent: who has sent it sends it again."""
        with suppress(LinkClosed):
            self._process.link.send(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        """:raises LinkClosed: if the world was stopped, or cannot go on."""
        process = self._process
        try:
            return process.link.receive(timeout_s)
        except LinkClosed:
            self._go_on_from(process)
            return ()

    def close(self) -> None:
        """Nothing to release: the link is the process's, which `stop` ends."""

    def stop(self) -> None:
        """End the process, in order, and wait for its end; safe to call again."""
        with self._lock:
            self._stopped = True
            self._process.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _go_on_from(self, gone: SimulationProcess) -> None:
        with self._lock:
            if self._stopped:
                raise LinkClosed("the world was stopped")
            if self._process is not gone:
                return
            gone.stop()
            self._count_death()
            try:
                begun = self._start(self._keep)
                begun.pause(self._paused)
                self._process = begun
            except SimulationError as error:
                logger.error("the world cannot go on: %s", error)
                raise LinkClosed(f"the world cannot go on: {error}") from error
            logger.warning(
                "the world's process died; process %s goes on from its snapshot", self._process.pid
            )

    def _count_death(self) -> None:
        now_s = self._wall_s()
        if len(self._deaths) == MOST and now_s - self._deaths[0] < WITHIN_S:
            logger.error("the world is given up: its process died %d times in %.0f s", MOST + 1, WITHIN_S)
            raise LinkClosed(f"the world's process died {MOST + 1} times in {WITHIN_S:.0f} s")
        self._deaths.append(now_s)
