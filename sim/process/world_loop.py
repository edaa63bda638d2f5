"""The loop inside a world's process: paces the simulation, answers its parent, ends with it."""

import contextlib
import gc
import os
import select
import signal
import threading
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from robots.clock import Clock
from robots.compiled import get_compiled
from robots.link import LinkClosed, PipeLink
from robots.world import Edition, WorldFile
from sim.clock import WallClock
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
from sim.process.debugger import Debugger
from sim.process.first_calls import SIMULATION
from sim.process.pacing import Pacer
from sim.process.snapshot_file import SnapshotFile, SnapshotSettings
from sim.world.hub import Hub

TELEMETRY_GAP_S = 0.05
"""Least wall time between two messages of one robot's telemetry."""
MAX_BUSY_S = 0.02
"""Longest wall time between two polls of the control channel."""
REST_AFTER_S = 3.0
"""Wall time without a moving robot and without a message other than telemetry, after which a world is at rest."""
REST_S = 0.25
"""Wall time that a world at rest sleeps; the control cycles due meanwhile are made together. A message ends it."""
END_S = 20.0
"""Wall time after which a process that was told to end does so itself, if its parent has not ended it."""
MIN_WAIT_S = 0.001
"""Shorter waits are rounded up; the control cycles due meanwhile are made together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldOrder:
    """The world that a process is to run. With `snapshots` it is stored on the disk, and resumed from there.

    `edition`: the world as changed since its file, None if it was not. `packet_files`: of the robots' repertoires;
    None: the packets that ship.
    """

    world: WorldFile
    seed: int
    speed: float | None
    jitter_m: float
    snapshots: SnapshotSettings | None = None
    edition: Edition | None = None
    packet_files: tuple[Path, ...] | None = None


@dataclass(frozen=True, slots=True)
class Channels:
    """A process's ends: control channel, link of the robots, and the world's time as it is shown."""

    control: "Connection[Any, Any]"
    link: "Connection[bytes, bytes]"
    now_s: SharedNumber


def run(order: WorldOrder, channels: Channels) -> None:
    """Build the world and run it until told to stop or the parent is gone."""
    handle_signals()
    gc.disable()  # it would scan what is being imported and built
    try:
        with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError, LinkClosed):
            get_compiled(SIMULATION, lambda doing: channels.control.send(Starting(doing)))
            world_loop = WorldLoop(order, channels, WallClock())
            gc.freeze()  # keeps the collector from scanning the world and the libraries' objects again and again
            gc.enable()
            world_loop.run()
    except SimulationError as error:
        with contextlib.suppress(OSError):
            channels.control.send(Failed(str(error)))
    except Exception:
        with contextlib.suppress(OSError):
            channels.control.send(Failed(traceback.format_exc()))
    finally:
        channels.link.close()
        channels.control.close()


def handle_signals() -> None:
    """Leave the end to the parent: it gets Ctrl-C, and from a service manager SIGTERM, too, and ends the world itself.

    If it does not, the process ends some time after SIGTERM.
    """

    def end_soon(*_: object) -> None:
        end = threading.Timer(END_S, os._exit, (1,))
        end.daemon = True
        end.start()

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, end_soon)


class WorldLoop:
    """One world, one control channel, one link."""

    def __init__(self, order: WorldOrder, channels: Channels, wall_clock: Clock) -> None:
        # NOTE: imported here, in the world's own process, because these load the physics.
        from sim.process.persistence import OutputCommit, resume_or_start
        from sim.world.agent_group import processes_for
        from sim.world.agents import agents_with
        from sim.world.simulation import Simulation

        self._channels = channels
        self._wall_clock = wall_clock
        self.stopped = False
        self._is_resumed = False
        self._not_resumed_because = ""
        self._file: SnapshotFile | None = None
        self._commit: OutputCommit | None = None
        world = order.world
        hub = Hub(
            PipeLink(channels.link),
            (),
            telemetry_gap_s=TELEMETRY_GAP_S,
            wall_clock=wall_clock,
            has_room=lambda: bool(select.select([], [channels.link], [], 0)[1]),
            holds=order.snapshots is not None,
        )
        processes = processes_for(len(world.simulated))
        make_agent = agents_with(order.packet_files)
        if order.snapshots is None:
            self._simulation = Simulation(
                world,
                make_agent=make_agent,
                seed=order.seed,
                jitter_m=order.jitter_m,
                hub=hub,
                edition=order.edition,
                processes=processes,
            )
        else:
            self._file = SnapshotFile(order.snapshots.path_of(world))
            started = resume_or_start(
                world,
                order.snapshots,
                self._file,
                hub,
                make_agent=make_agent,
                seed=order.seed,
                jitter_m=order.jitter_m,
                edition=order.edition,
                processes=processes,
            )
            self._simulation = started.simulation
            self._is_resumed = started.is_resumed
            self._not_resumed_because = started.not_resumed_because
            self._commit = OutputCommit(self._simulation, self._file, wall_clock)
            self._commit.take()
        self._letters = 0
        self._rests_from_s = wall_clock.now_s() + REST_AFTER_S
        self._pacer = Pacer(wall_clock, order.speed, self._simulation.clock.now_s())
        self._is_paused = False
        self._debugger = Debugger(self._simulation, wall_clock)
        self._show_time()

    def run(self) -> None:
        """Run until told to stop.

        :raises EOFError, LinkClosed: if the parent is gone.
        """
        self._channels.control.send(
            Ready(
                run=self._simulation.run,
                robots=tuple(self._simulation.bodies),
                is_resumed=self._is_resumed,
                not_resumed_because=self._not_resumed_because,
            )
        )
        try:
            while not self.stopped:
                self.cycle()
        finally:
            if self._file is not None:
                self._file.close()

    def cycle(self) -> None:
        """Make the control cycles that are due, take a snapshot if it is due, and answer a command."""
        if self._debugger.end_if_over():
            self._renew_pace()
        wait_s = self._advance()
        at_rest = self._is_at_rest()
        if self._commit is not None:
            self._commit.take_if_due(at_rest=at_rest)
        if wait_s is None:  # a paused world must not let the service's messages fill the pipe
            wait([self._channels.control, self._channels.link], self._debugger.left_s)
            self._simulation.hub.receive(self._simulation.clock.now_s())
        elif at_rest and wait_s > 0.0:
            self._rest(max(wait_s, REST_S))
            wait_s = 0.0
        if self._channels.control.poll(wait_s or 0.0):
            self._execute(self._channels.control.recv())

    def _is_at_rest(self) -> bool:
        """True when for `REST_AFTER_S` no robot has been commanded to move and no message has passed."""
        now_s = self._wall_clock.now_s()
        letters = self._simulation.hub.letters
        if letters != self._letters or not self._simulation.is_still:
            self._letters = letters
            self._rests_from_s = now_s + REST_AFTER_S
        return now_s >= self._rests_from_s

    def _rest(self, sleep_s: float) -> None:
        """Sleep, until a command or a message arrives."""
        if self._channels.link in wait([self._channels.control, self._channels.link], sleep_s):
            self._rests_from_s = self._wall_clock.now_s() + REST_AFTER_S

    def _advance(self) -> float | None:
        """Make the control cycles that are due, for `MAX_BUSY_S` at most; returns how long to wait for a command.

        A cycle begins with the agents' turn, and nothing outside sees the ticks within it: waking for each of them
        would cost a world at rest a third more.
        """
        poll_at_s = self._wall_clock.now_s() + MAX_BUSY_S
        clock = self._simulation.clock
        while (wait_s := self._pacer.wait_s(clock.now_s())) == 0.0:
            self._simulation.step_control_cycle()
            self._show_time()
            if self._debugger.stepped():
                self._stand()
                return None
            if self._wall_clock.now_s() >= poll_at_s:
                return 0.0
        return None if wait_s is None else max(wait_s, MIN_WAIT_S)

    def _show_time(self) -> None:
        now_s = self._simulation.clock.now_s()
        if self._file is not None:
            self._file.write_clock(now_s)
        self._channels.now_s.value = now_s

    def _execute(self, command: Command) -> None:
        answer: Answer = Done()
        match command:
            case AskTruth():
                answer = self._simulation.truth()
            case Pause(paused):
                self._is_paused = paused
                self._stand()
            case BreakAt(robot, rules):
                self._debugger.break_at(robot, rules)
                self._renew_pace()
                answer = self._debugger.state()
            case GoOn(one_cycle):
                self._go_on(one_cycle=one_cycle)
                answer = self._debugger.state()
            case AskDebugging():
                answer = self._debugger.state()
            case Stop():
                self._take_snapshot()
                self.stopped = True
                return
        self._channels.control.send(answer)

    def _go_on(self, *, one_cycle: bool) -> None:
        """Leave a breakpoint, for good or for one control cycle; a paused world makes none."""
        if not self._debugger.stands:
            return
        if one_cycle and not self._is_paused:
            self._simulation.step_control_cycle()
            self._show_time()
            self._debugger.stand_again()
            self._renew_pace()
            self._take_snapshot()
        elif not one_cycle:
            self._debugger.go_on()
            self._renew_pace()

    def _stand(self) -> None:
        self._renew_pace()
        self._take_snapshot()  # held messages would otherwise wait as long as the pause

    def _renew_pace(self) -> None:
        """Pause, or go on without catching up."""
        stands = self._is_paused or self._debugger.stands
        self._pacer.pause(stands, self._simulation.clock.now_s())

    def _take_snapshot(self) -> None:
        if self._commit is not None:
            self._commit.take()
