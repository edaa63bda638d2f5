"""A simulated world in its own process (not a thread: PyBullet never lets go of the interpreter's lock)."""

import multiprocessing
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Lock
from typing import Any, Self

from robots.link import PipeLink
from robots.world import WorldFile
from sim.error import SimulationError
from sim.process.control import Answer, AskTruth, Command, Done, Failed, Gauge, Pause, Ready, SetSpeed, Stop
from sim.process.keep import Keep
from sim.process.world_loop import Order, run
from sim.truth import Truth

START_S = 180.0
ANSWER_S = 10.0
STOP_S = 5.0


class SimulationProcess:
    """A running world as the service sees it: `link` to its robots, its clock, and a control channel.

    It ends with `stop`, at the end of a `with` block, or with the process that started it. Thread-safe.
    """

    def __init__(
        self, process: BaseProcess, control: "Connection[Any, Any]", link: PipeLink, now: Gauge, factor: Gauge
    ) -> None:
        self._process, self._control, self._now, self._factor = process, control, now, factor
        self._lock = Lock()
        self.link = link
        self.run = ""
        """Names the world from its building on, however often it is resumed."""
        self.why_afresh = ""
        """Why it was built where it might have gone on."""

    @classmethod
    def start(
        cls,
        world: WorldFile,
        *,
        seed: int = 0,
        speed: float | None = 1.0,
        jitter_m: float = 0.4,
        keep: Keep | None = None,
    ) -> "SimulationProcess":
        """Start a world and wait until it is built.

        :param speed: world seconds a wall second; None is flat out.
        :param keep: where it is kept on the disk, to go on from; not at all unless given.
        :raises SimulationError: if it cannot be built; the message says why.
        """
        context = multiprocessing.get_context("spawn")
        control, far_control = context.Pipe()
        link, far_link = context.Pipe()
        now, factor = context.RawValue("d", 0.0), context.RawValue("d", 0.0)
        order = Order(world=world, seed=seed, speed=speed, jitter_m=jitter_m, keep=keep)
        process = context.Process(
            target=run,
            args=(order, far_control, far_link, now, factor),
            name=f"world-{world.name}",
            daemon=True,
        )
        _start_deaf_to_interrupts(process.start)
        far_control.close()
        far_link.close()
        started = cls(process, control, PipeLink(link), now, factor)
        try:
            started._expect_ready(started._receive(START_S))
        except SimulationError:
            started.stop()
            raise
        return started

    @property
    def pid(self) -> int | None:
        return self._process.pid

    @property
    def alive(self) -> bool:
        return self._process.is_alive()

    @property
    def real_time_factor(self) -> float:
        """World seconds a wall second over the last second; below the wished speed if it cannot keep up."""
        return self._factor.value

    def now_s(self) -> float:
        """The world's clock; implements `robots.clock.Clock`. Stands still when the process is gone."""
        return self._now.value

    def truth(self) -> Truth:
        """The world as it is; never for an agent or the planner."""
        answer = self._ask(AskTruth())
        if not isinstance(answer, Truth):
            raise SimulationError(f"the world answered {answer} when asked for its truth")
        return answer

    def set_speed(self, speed: float | None) -> None:
        """:raises SimulationError: if the speed is not above 0 (None: flat out)."""
        self._expect_done(self._ask(SetSpeed(speed)))

    def pause(self, paused: bool = True) -> None:
        """Let the world stand still, or go on."""
        self._expect_done(self._ask(Pause(paused)))

    def stop(self) -> None:
        """End the process and wait for its end; safe to call again."""
        with self._lock:
            if self._process.is_alive():
                _try_send(self._control, Stop())
            self._process.join(STOP_S)
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
            _try_send(self._control, command)
            # NOTE: a world that broke has left its reason in the pipe, so it is read even if nobody was there to ask.
            return self._receive(ANSWER_S)

    def _receive(self, timeout_s: float) -> Answer:
        try:
            if not self._control.poll(timeout_s):
                raise SimulationError(f"the world did not answer within {timeout_s} s")
            answer: Answer = self._control.recv()
        except (EOFError, OSError) as error:
            raise SimulationError(
                f"the world's process is gone (exit code {self._process.exitcode})"
            ) from error
        return answer

    def _expect_ready(self, answer: Answer) -> None:
        if not isinstance(answer, Ready):
            raise SimulationError(
                answer.reason if isinstance(answer, Failed) else f"the world began by {answer}"
            )
        self.run, self.why_afresh = answer.run, answer.why_afresh

    @staticmethod
    def _expect_done(answer: Answer) -> None:
        if isinstance(answer, Failed):
            raise SimulationError(answer.reason)
        if not isinstance(answer, Done):
            raise SimulationError(f"the world answered {answer} to a command")


def _try_send(control: "Connection[Any, Any]", command: Command) -> bool:
    try:
        control.send(command)
    except (OSError, ValueError):
        return False
    return True


def _start_deaf_to_interrupts(start: Callable[[], None]) -> None:
    """A child inherits the signal mask: the operator's Ctrl-C does not reach it, not even while it starts."""
    kept = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, kept)
