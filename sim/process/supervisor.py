"""A simulated world whose process is replaced when it crashes; the new process resumes from the last snapshot."""

import logging
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from threading import Lock
from typing import Self

from robots.clock import Clock
from robots.executive.breakpoints import Debugging
from robots.link import LinkClosed
from robots.wire import Message
from robots.world import Edition, WorldFile
from sim.clock import WallClock
from sim.error import SimulationError
from sim.process.process import SimulationProcess
from sim.process.snapshot_file import SnapshotSettings
from sim.truth import Truth

MAX_CRASHES = 5
CRASH_WINDOW_S = 120.0
"""If the process crashes more often than `MAX_CRASHES` in this wall-clock time, it is not replaced again."""

logger = logging.getLogger(__name__)

StartProcess = Callable[[SnapshotSettings], SimulationProcess]


class SupervisedWorld:
    """Implements `robots.link.Link` and `robots.clock.Clock` on top of the present simulation process.

    `receive` detects that the process has ended and starts the next one; messages in transit are lost. Until then the
    clock stands still; it never goes back.
    """

    def __init__(
        self, start_process: StartProcess, snapshots: SnapshotSettings, wall_clock: Clock | None = None
    ) -> None:
        self._start_process = start_process
        self._wall_clock = wall_clock or WallClock()
        self._process = start_process(snapshots)
        self.run = self._process.run
        self.robots = self._process.robots
        """Those of the edition that it began with."""
        self.is_resumed = self._process.is_resumed
        self.not_resumed_because = self._process.not_resumed_because
        self._resume = replace(snapshots, run=self.run, any_run=False, start_new=False, resume_only=True)
        self._crashes_at_s: deque[float] = deque(maxlen=MAX_CRASHES)
        self._lock = Lock()
        self._paused = False
        self._stopped = False

    @classmethod
    def start(
        cls,
        world: WorldFile,
        snapshots: SnapshotSettings,
        *,
        seed: int,
        speed: float,
        jitter_m: float,
        edition: Edition | None = None,
        packet_files: tuple[Path, ...] | None = None,
        tell: Callable[[str], None] = logger.info,
    ) -> Self:
        """
        :param edition: the world as changed since its file.
        :param packet_files: of the robots' repertoires; None: the packets that ship.
        :param tell: called with a message when the start takes long, such as while functions are compiled.
        :raises SimulationError: if the world cannot be built; the message says why.
        """

        def start_process(settings: SnapshotSettings) -> SimulationProcess:
            return SimulationProcess.start(
                world,
                seed=seed,
                speed=speed,
                jitter_m=jitter_m,
                snapshots=settings,
                edition=edition,
                packet_files=packet_files,
                tell=tell,
            )

        return cls(start_process, snapshots)

    @property
    def pid(self) -> int | None:
        """Id of the present process."""
        return self._process.pid

    def now_s(self) -> float:
        return self._process.now_s()

    def truth(self) -> Truth:
        """The true state of the world; not for robots' agents or the planner.

        :raises SimulationError: if no process is running.
        """
        return self._process.truth()

    def pause(self, paused: bool = True) -> None:
        """Pause the world, or let it continue; also applies to later processes."""
        with self._lock, suppress(SimulationError):
            self._paused = paused
            self._process.pause(paused)

    def break_at(self, robot: str, rules: frozenset[str]) -> Debugging:
        """Set the breakpoints of a robot's rules; they end with the present process.

        :raises SimulationError: if no process is running, as for the next ones.
        """
        return self._process.break_at(robot, rules)

    def go_on(self, *, one_cycle: bool) -> Debugging:
        """Let a world that stands at a breakpoint go on, or make one control cycle and stand again."""
        return self._process.go_on(one_cycle=one_cycle)

    def debugging(self) -> Debugging:
        """The breakpoints, and where the world stands."""
        return self._process.debugging()

    def send(self, message: Message) -> None:
        """Send a message; if the process has ended it is lost, and the sender has to repeat it."""
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
        """Does nothing: the link is closed with the process, by `stop`."""

    def stop(self) -> None:
        """Shut the process down and wait for its end; may be called again."""
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
            self._count_crash()
            try:
                process = self._start_process(self._resume)
                try:
                    process.pause(self._paused)
                except SimulationError:
                    process.stop()
                    raise
            except SimulationError as error:
                logger.error("the world cannot be resumed: %s", error)
                raise LinkClosed(f"the world cannot be resumed: {error}") from error
            self._process = process
            logger.warning(
                "simulation process ended unexpectedly; process %s resumes the world from its snapshot",
                process.pid,
            )

    def _count_crash(self) -> None:
        now_s = self._wall_clock.now_s()
        if len(self._crashes_at_s) == MAX_CRASHES and now_s - self._crashes_at_s[0] < CRASH_WINDOW_S:
            reason = f"the simulation process crashed {MAX_CRASHES + 1} times within {CRASH_WINDOW_S:.0f} s"
            logger.error("%s; it is not started again", reason)
            raise LinkClosed(reason)
        self._crashes_at_s.append(now_s)
