"""A simulated world in its own process (not a thread: PyBullet holds the interpreter's lock)."""

import logging
import multiprocessing
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Lock
from typing import Any, Self

from robots.child_processes import start_child
from robots.executive.breakpoints import Debugging
from robots.link import PipeLink
from robots.world import Edition, WorldFile
from sim.error import SimulationError
from sim.process.control import (
    Answer,
    AskDebugging,
    AskTruth,
    BreakAt,
    Command,
    Done,
    Failed,
    GoOn,
    Pause,
    Ready,
    SharedNumber,
    Starting,
    Stop,
)
from sim.process.snapshot_file import SnapshotSettings
from sim.process.world_loop import Channels, WorldOrder, run
from sim.truth import Truth

logger = logging.getLogger(__name__)

ANSWER_TIMEOUT_S = 10.0
STOP_TIMEOUT_S = 5.0


class SimulationProcess:
    """A running world as the service sees it: `link` to its robots, its clock, and a control channel.

    It ends with `stop`, at the end of a `with` block, or with the process that started it. Thread-safe.
    """

    def __init__(
        self,
        process: BaseProcess,
        control: "Connection[Any, Any]",
        link: PipeLink,
        now_s: SharedNumber,
        tell: Callable[[str], None],
    ) -> None:
        """Wait until the world is built, for as long as that takes.

        :raises SimulationError: if the world is not built; the process is then ended.
        """
        self.link = link
        self._process = process
        self._control = control
        self._now_s = now_s
        self._lock = Lock()
        self._answers_due = 0
        try:
            while isinstance(ready := self._receive(None), Starting):
                tell(ready.doing)
            if not isinstance(ready, Ready):
                raise SimulationError(f"the world's first message was {ready}")
        except SimulationError:
            self.stop()
            raise
        self.run = ready.run
        """Identifies the world, however often it is resumed."""
        self.robots = ready.robots
        """Those of the edition that it began with."""
        self.is_resumed = ready.is_resumed
        """Whether it goes on from a snapshot."""
        self.not_resumed_because = ready.not_resumed_because
        """Why it was not resumed, if a snapshot was expected; else empty."""

    @classmethod
    def start(
        cls,
        world: WorldFile,
        *,
        seed: int = 0,
        speed: float | None = 1.0,
        jitter_m: float = 0.4,
        snapshots: SnapshotSettings | None = None,
        edition: Edition | None = None,
        packet_files: tuple[Path, ...] | None = None,
        tell: Callable[[str], None] = logger.info,
    ) -> "SimulationProcess":
        """Start a world and wait until it is built.

        :param speed: world seconds per wall second; None is as fast as possible.
        :param snapshots: where it is stored to be resumed; None: it is not stored.
        :param edition: the world as changed since its file.
        :param packet_files: of the robots' repertoires; None: the packets that ship.
        :param tell: called with a message when the start takes long, such as while functions are compiled.
        :raises SimulationError: if it cannot be built; the message says why.
        """
        control, far_control = multiprocessing.Pipe()
        link, far_link = multiprocessing.Pipe()
        now_s = multiprocessing.RawValue("d", 0.0)
        order = WorldOrder(
            world=world,
            seed=seed,
            speed=speed,
            jitter_m=jitter_m,
            snapshots=snapshots,
            edition=edition,
            packet_files=packet_files,
        )
        process = start_child(run, order, Channels(far_control, far_link, now_s), name=f"world-{world.name}")
        far_control.close()
        far_link.close()
        return cls(process, control, PipeLink(link), now_s, tell)

    @property
    def pid(self) -> int | None:
        return self._process.pid

    @property
    def alive(self) -> bool:
        return self._process.is_alive()

    def now_s(self) -> float:
        """The world's clock; implements `robots.clock.Clock`. Stands still when the process is gone."""
        return self._now_s.value

    def truth(self) -> Truth:
        """The world as it is; never for an agent or the planner."""
        answer = self._ask(AskTruth())
        if not isinstance(answer, Truth):
            raise SimulationError(f"the world answered {answer} when asked for its truth")
        return answer

    def pause(self, paused: bool = True) -> None:
        """Pause the world, or let it continue."""
        answer = self._ask(Pause(paused))
        if not isinstance(answer, Done):
            raise SimulationError(f"the world answered {answer} to a command")

    def break_at(self, robot: str, rules: frozenset[str]) -> Debugging:
        """Set the breakpoints of a robot's rules, "guard:3" and the like."""
        return self._debug(BreakAt(robot, rules))

    def go_on(self, *, one_cycle: bool) -> Debugging:
        """Let a world that stands at a breakpoint go on, or make one control cycle and stand again."""
        return self._debug(GoOn(one_cycle))

    def debugging(self) -> Debugging:
        """The breakpoints, and where the world stands."""
        return self._debug(AskDebugging())

    def _debug(self, command: Command) -> Debugging:
        answer = self._ask(command)
        if not isinstance(answer, Debugging):
            raise SimulationError(f"the world answered {answer} to a command")
        return answer

    def stop(self) -> None:
        """End the process and wait for its end; safe to call again."""
        with self._lock:
            if self._process.is_alive():
                self._send(Stop())
            self._process.join(STOP_TIMEOUT_S)
            if self._process.is_alive():
                self._process.kill()
                self._process.join()
            self._control.close()
            self.link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _ask(self, command: Command) -> Answer:
        with self._lock:
            self._send(command)
            self._answers_due += 1
            while True:  # first the late answers to commands that timed out
                answer = self._receive(ANSWER_TIMEOUT_S)
                self._answers_due -= 1
                if self._answers_due == 0:
                    return answer

    def _send(self, command: Command) -> None:
        """Failure is ignored here: a world that broke has left its reason in the pipe, to be received next."""
        with suppress(OSError, ValueError):
            self._control.send(command)

    def _receive(self, timeout_s: float | None) -> Answer:
        """:param timeout_s: None waits as long as the process lives."""
        try:
            if not self._control.poll(timeout_s):
                raise SimulationError(f"the world did not answer within {timeout_s} s")
            answer: Answer = self._control.recv()
        except (EOFError, OSError) as error:
            raise SimulationError(
                f"the world's process is gone (exit code {self._process.exitcode})"
            ) from error
        if isinstance(answer, Failed):
            raise SimulationError(answer.reason)
        return answer
