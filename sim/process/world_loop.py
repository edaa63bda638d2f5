"""The loop inside a world's process: paces the simulation, answers its parent, ends with it."""

import contextlib
import select
import signal
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from robots.link import LinkClosed, PipeLink
from robots.world import WorldFile
from sim.error import SimulationError
from sim.process.control import Answer, AskTruth, Command, Done, Failed, Gauge, Pause, Ready, SetSpeed, Stop
from sim.process.keep import Keep
from sim.process.pacing import Pacer
from sim.world.hub import Hub
from sim.world.radio import radios_of

TELEMETRY_GAP_S = 0.05  # of the wall clock
LOOK_S = 0.02
"""At most this much wall time passes between two looks at the control channel."""
NAP_S = 0.001
"""Shorter waits are not worth going to sleep for; the ticks they are for are made together after one nap."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What a world's process is to run. With `keep` it is kept on the disk, and goes on from there."""

    world: WorldFile
    seed: int
    speed: float | None
    jitter_m: float
    keep: Keep | None = None


def run(
    order: Order, control: "Connection[Any, Any]", link: "Connection[bytes, bytes]", now: Gauge, factor: Gauge
) -> None:
    """Build the world and run it until told to stop or the parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    try:
        with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError, LinkClosed):
            WorldLoop(order, control, link, now, factor).run()
    except SimulationError as error:
        with contextlib.suppress(OSError):
            control.send(Failed(str(error)))
    except Exception:
        with contextlib.suppress(OSError):
            control.send(Failed(traceback.format_exc()))
    finally:
        link.close()
        control.close()


class WorldLoop:
    """One world, one control channel, one link."""

    def __init__(
        self,
        order: Order,
        control: "Connection[Any, Any]",
        link: "Connection[bytes, bytes]",
        now: Gauge,
        factor: Gauge,
    ) -> None:
        from sim.process.output_commit import OutputCommit
        from sim.process.snapshot_file import SnapshotFile
        from sim.process.world_start import begin
        from sim.world.agents import behavioural_agent
        from sim.world.simulation import Simulation

        world, keep = order.world, order.keep
        hub = Hub(
            PipeLink(link),
            [spec.name for spec in world.robots],
            telemetry_gap_s=TELEMETRY_GAP_S,
            wall_s=time.monotonic,
            has_room=lambda: bool(select.select([], [link], [], 0)[1]),
            radios=radios_of(world, order.seed),
            holds=keep is not None,
        )
        drawn: dict[str, Any] = {"seed": order.seed, "jitter_m": order.jitter_m, "hub": hub}
        self._why_afresh = ""
        self._file: SnapshotFile | None = None
        self._commit: OutputCommit | None = None
        if keep is None:
            self._simulation = Simulation(world, make_agent=behavioural_agent, **drawn)
        else:
            self._file = SnapshotFile(keep.file_of(world))
            begun = begin(world, keep, self._file, **drawn)
            self._simulation, self._why_afresh = begun.simulation, begun.why_afresh
            self._commit = OutputCommit(self._simulation, self._file, time.monotonic)
            self._commit.take()
        self._control, self._link, self._now, self._factor = control, link, now, factor
        self._pacer = Pacer(time.monotonic, order.speed, self._simulation.clock.now_s())
        self._show_time()
        self._stopped = False

    def run(self) -> None:
        """Until told to stop.

        :raises EOFError: if the parent is gone; so does `LinkClosed`.
        """
        self._control.send(Ready(self._simulation.run, self._why_afresh))
        try:
            self._go_on()
        finally:
            if self._file is not None:
                self._file.close()

    def _go_on(self) -> None:
        while not self._stopped:
            wait_s = self._advance()
            if self._commit is not None:
                self._commit.consider()
            self._factor.value = self._pacer.real_time_factor
            if wait_s is None:  # a world that stands still must not let the service's messages fill the pipe
                wait([self._control, self._link])
                self._simulation.hub.fetch(self._simulation.clock.now_s())
            if self._control.poll(wait_s or 0.0):
                self._answer(self._control.recv())

    def _advance(self) -> float | None:
        """Make the ticks that are due, for `LOOK_S` at most; how long then to wait for a command."""
        look_at_s = time.monotonic() + LOOK_S
        clock = self._simulation.clock
        while (wait_s := self._pacer.wait_s(clock.now_s())) == 0.0:
            self._simulation.step()
            self._show_time()
            if time.monotonic() >= look_at_s:
                return 0.0
        return None if wait_s is None else max(wait_s, NAP_S)

    def _take_snapshot(self) -> None:
        if self._commit is not None:
            self._commit.take()

    def _show_time(self) -> None:
        now_s = self._simulation.clock.now_s()
        if self._file is not None:
            self._file.show_time(now_s)
        self._now.value = now_s

    def _answer(self, command: Command) -> None:
        world_s = self._simulation.clock.now_s()
        answer: Answer = Done()
        match command:
            case AskTruth():
                answer = self._simulation.truth()
            case SetSpeed(speed):
                answer = self._try_speed(speed, world_s)
            case Pause(paused):
                self._pacer.pause(paused, world_s)
                self._take_snapshot()  # what waits for one would wait as long as the world stands still
            case Stop():
                self._take_snapshot()
                self._stopped = True
                return
        self._control.send(answer)

    def _try_speed(self, speed: float | None, world_s: float) -> Answer:
        try:
            self._pacer.set_speed(speed, world_s)
        except ValueError as error:
            return Failed(str(error))
        return Done()
