"""The agents of a world, in its own process or spread over several.

Within a control tick agents do not depend on each other: each reads what its sensors read before the tick, and its
messages. A group in another process gets both, and returns what its agents command and send. That is carried out in
the order of the robots, so that a run is the same to the last bit however many processes there are.
"""

import os
import pickle
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import ceil
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, Protocol
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from robots.compilation import compiles
from robots.compiled import use_compiled
from robots.executive.breakpoints import Halt
from robots.executive.memory import RobotMemory
from robots.link import Link
from robots.physical.body import Body
from sim.clock import WorldClock
from sim.error import SimulationError
from sim.world.agent import Agent, AgentFactory, AgentSetup, HasMemory, HasRules, TellsOfItself
from sim.world.remote_robot import ReadingsSender, RemoteRobot, numbers_of

ROBOTS_A_PROCESS = 30
"""With fewer robots another process costs more than it saves."""
END_TIMEOUT_S = 2.0
NOTHING = np.empty(0)


def processes_for(robots: int) -> int:
    """The number of processes that the agents of a world are worth on this machine."""
    return max(1, min(len(os.sched_getaffinity(0)), ceil(robots / ROBOTS_A_PROCESS)))


class Tick(NamedTuple):
    """What a group's robots feel in one control tick, in their order.

    `rest`: a row a robot, as `ReadingsSender` makes it. `numbers`: all their ranges and sightings, one after the other.
    `is_compiled`: False while the world's process runs compiled functions as Python.
    """

    ticks: int
    rest: Sequence[tuple[Any, ...]]
    numbers: NDArray[np.float64]
    is_compiled: bool


class Makeup(NamedTuple):
    """The agents that a group's process is to run from now on, in place of those before; those whose software can go
    on do. Not answered.
    """

    make_agent: AgentFactory
    setups: Sequence[AgentSetup]
    robots: Sequence[RemoteRobot]
    clock: WorldClock


class Memories(NamedTuple):
    """Asks for the agents' memories. `is_whole`: with what does not outlive a power failure."""

    is_whole: bool


class BreakAt(NamedTuple):
    """Breakpoints on rules, by robot, in place of those before. Not answered."""

    rules: Mapping[str, frozenset[str]]


class AskHalts(NamedTuple):
    """Asks where minds stand: of robots that are held at a breakpoint, and of these."""

    robots: frozenset[str]


class Failed(NamedTuple):
    """An agent raised an error, in words."""

    reason: str


class AgentGroup(Protocol):
    """Agents that tick together. Each `begin` is followed by its `finish`."""

    def begin_tick(self, ticks: int) -> None: ...

    def finish_tick(self) -> None: ...

    def begin_memories(self, *, is_whole: bool) -> None:
        """:param is_whole: with what does not outlive a power failure."""
        ...

    def finish_memories(self) -> Mapping[str, RobotMemory]: ...

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None:
        """Set breakpoints on rules, by robot."""
        ...

    def halts(self, robots: frozenset[str]) -> Sequence[Halt]:
        """Where minds stand: of robots that are held at a breakpoint, and of these."""
        ...

    def close(self) -> None: ...


class LocalGroup:
    """Agents in this process. Implements `AgentGroup`."""

    def __init__(
        self, make_agent: AgentFactory, setups: Sequence[AgentSetup], *, before: "LocalGroup | None" = None
    ) -> None:
        """:param before: the group in whose place this one steps; agents whose setup is the same go on in it."""
        kept = {} if before is None else before._going_on(setups)
        self.kept = frozenset(kept)
        """The agents that go on."""
        self._setups = {setup.spec.name: setup for setup in setups}
        self._is_whole = False
        self.agents: dict[str, Agent] = {
            name: kept.get(name) or make_agent(setup) for name, setup in self._setups.items()
        }
        for name, agent in kept.items():
            if isinstance(agent, TellsOfItself):
                agent.announce(self._setups[name].factsheet)

    def _going_on(self, setups: Sequence[AgentSetup]) -> dict[str, Agent]:
        """The agents that go on: the same in whichever process they are, so only if the world has the same robots."""
        if [setup.spec.name for setup in setups] != list(self._setups):
            return {}
        return {
            setup.spec.name: self.agents[setup.spec.name]
            for setup in setups
            if setup.is_for_the_same_software(self._setups[setup.spec.name])
        }

    def begin_tick(self, ticks: int) -> None:
        for agent in self.agents.values():
            agent.tick()

    def finish_tick(self) -> None:
        """Done already."""

    def begin_memories(self, *, is_whole: bool) -> None:
        self._is_whole = is_whole

    def finish_memories(self) -> Mapping[str, RobotMemory]:
        return {
            name: agent.memory(is_whole=self._is_whole)
            for name, agent in self.agents.items()
            if isinstance(agent, HasMemory)
        }

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None:
        for name, agent in self.agents.items():
            if isinstance(agent, HasRules):
                agent.break_at(rules.get(name, frozenset()))

    def halts(self, robots: frozenset[str]) -> Sequence[Halt]:
        ruled = [(name, one) for name, one in self.agents.items() if isinstance(one, HasRules)]
        return [one.halt_report() for name, one in ruled if one.is_held or name in robots]

    def close(self) -> None:
        """Nothing to release."""


class RemoteGroup:
    """Agents in a process of their own, which ends with this one. Implements `AgentGroup`."""

    def __init__(self, make_agent: AgentFactory, setups: Sequence[AgentSetup], clock: WorldClock) -> None:
        """:param make_agent: a function of a module, since it is pickled. :param clock: the setups' own."""
        ours, far = socket.socketpair()
        with far:
            code = f"from sim.world.agent_group import serve; serve({far.fileno()})"
            # NOTE: not by multiprocessing: the world's process is a daemon of it, and must not have children by it.
            self._process = subprocess.Popen([sys.executable, "-c", code], pass_fds=[far.fileno()])
        self._connection: Connection[Any, Any] = Connection(ours.detach())
        self._close = finalize(self, _end, self._connection, self._process)
        self.make(make_agent, setups, clock)

    def make(self, make_agent: AgentFactory, setups: Sequence[AgentSetup], clock: WorldClock) -> None:
        """Run these agents from now on, in place of those before; those whose software can go on do."""
        self._robots: list[tuple[Body, Link]] = [(setup.body, setup.link) for setup in setups]
        self._senders = [ReadingsSender() for _ in setups]
        robots = [RemoteRobot() for _ in setups]
        pairs = zip(setups, robots, strict=True)
        far = [replace(setup, body=robot, link=robot) for setup, robot in pairs]
        self._send(Makeup(make_agent, far, robots, clock))

    def begin_tick(self, ticks: int) -> None:
        rest = []
        numbers = [NOTHING]
        for (body, link), sender in zip(self._robots, self._senders, strict=True):
            readings = body.sense()
            rest.append(sender.packed(body.get_position(), readings, link.receive()))
            numbers += numbers_of(readings)
        self._send(Tick(ticks, rest, np.concatenate(numbers), compiles()))

    def finish_tick(self) -> None:
        for (body, link), (velocity, grips, sensors, sent) in zip(self._robots, self._answer(), strict=True):
            if velocity is not None:
                body.set_velocity(*velocity)
            for closed in grips:
                body.set_gripper(closed=closed)
            if sensors is not None:
                body.run_sensors(sensors)
            for message in sent:
                link.send(message)

    def begin_memories(self, *, is_whole: bool) -> None:
        self._send(Memories(is_whole))

    def finish_memories(self) -> Mapping[str, RobotMemory]:
        memories: Mapping[str, RobotMemory] = self._answer()
        return memories

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None:
        self._send(BreakAt(rules))

    def halts(self, robots: frozenset[str]) -> Sequence[Halt]:
        self._send(AskHalts(robots))
        halts: Sequence[Halt] = self._answer()
        return halts

    def close(self) -> None:
        self._close()

    def _send(self, order: object) -> None:
        try:
            self._connection.send_bytes(pickle.dumps(order, pickle.HIGHEST_PROTOCOL))
        except OSError as error:
            raise SimulationError(f"the agents' process {self._process.pid} is gone") from error

    def _answer(self) -> Any:
        """:raises SimulationError: if an agent raised an error, or the process is gone."""
        try:
            answer = pickle.loads(self._connection.recv_bytes())
        except (EOFError, OSError) as error:
            raise SimulationError(f"the agents' process {self._process.pid} is gone") from error
        if isinstance(answer, Failed):
            raise SimulationError(answer.reason)
        return answer


def _end(connection: "Connection[Any, Any]", process: "subprocess.Popen[bytes]") -> None:
    connection.close()
    try:
        process.wait(END_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def serve(handle: int) -> None:
    """Run a group's agents in this process until the world's process closes its end of the socket."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the service handles them, and ends the world, which ends this
    connection: Connection[Any, Any] = Connection(handle)
    with suppress(EOFError, OSError):
        try:
            group = _FarGroup(pickle.loads(connection.recv_bytes()))
            while True:
                order = pickle.loads(connection.recv_bytes())
                if isinstance(order, Makeup):
                    group = _FarGroup(order, group)
                    continue
                if isinstance(order, BreakAt):
                    group.break_at(order.rules)
                    continue
                answer = group.answer(order)
                connection.send_bytes(pickle.dumps(answer, pickle.HIGHEST_PROTOCOL))
        except (EOFError, OSError):
            raise
        except Exception:
            connection.send_bytes(pickle.dumps(Failed(traceback.format_exc())))


class _FarGroup:
    """The agents of a `RemoteGroup`, in their own process."""

    def __init__(self, makeup: Makeup, before: "_FarGroup | None" = None) -> None:
        self._clock: WorldClock = makeup.clock if before is None else before._clock
        setups = [replace(setup, clock=self._clock) for setup in makeup.setups]
        self._agents: LocalGroup = LocalGroup(
            makeup.make_agent, setups, before=None if before is None else before._agents
        )
        names = [setup.spec.name for setup in setups]
        theirs = {} if before is None else before._by_name
        self._by_name: dict[str, RemoteRobot] = {
            name: theirs[name] if name in self._agents.kept else robot
            for name, robot in zip(names, makeup.robots, strict=True)
        }
        self._robots = tuple(self._by_name.values())

    def break_at(self, rules: Mapping[str, frozenset[str]]) -> None:
        self._agents.break_at(rules)

    def answer(self, order: Tick | Memories | AskHalts) -> object:
        if isinstance(order, Memories):
            self._agents.begin_memories(is_whole=order.is_whole)
            return self._agents.finish_memories()
        if isinstance(order, AskHalts):
            return self._agents.halts(order.robots)
        if order.is_compiled and not compiles():
            use_compiled()
        self._clock.ticks = order.ticks
        numbers = order.numbers
        for robot, row in zip(self._robots, order.rest, strict=True):
            numbers = numbers[robot.feel(row, numbers) :]
        self._agents.begin_tick(order.ticks)
        return [robot.commands.packed for robot in self._robots]
