"""Faults injected into the service: its processes are killed at random times, together or singly, and restarted."""

import random
import signal
import threading
from collections import Counter
from collections.abc import Callable

import httpx2

from app.cli.trials.service_process import Installation, NotReady, ServiceProcess
from app.domain.clock import pause
from app.planning.pool.process_tree import Running, kill
from app.workflows.background import Background

WorldFault = Callable[[random.Random], str]
"""Changes the world while no service runs; returns the name of the fault, empty if nothing was changed."""

KINDS = {
    "service killed": 4,
    "service killed during its start": 2,
    "service restarted": 1,
    "simulation killed": 3,
    "planning killed": 3,
    "service stopped for 2 s": 1,
}
"""Kinds of faults with their weights."""
PAUSE_S = (2.0, 15.0)
STOPPED_S = 2.0
SIMULATION_PAUSE_S = 25.0
"""Least time between two kills of the simulation: the service gives up a world that ends six times in two minutes."""


class ServiceFaults:
    """Runs the service, and kills or restarts it at random in a background thread. Thread-safe."""

    def __init__(self, installation: Installation, seed: int, world_fault: WorldFault = lambda _: "") -> None:
        self._installation = installation
        self._clock = installation.clock
        self._rng = random.Random(seed)
        self._world_fault = world_fault
        self._lock = threading.Lock()
        self._starts = 0
        self._simulation_killed_s = float("-inf")
        self._background: Background | None = None
        self.done: Counter[str] = Counter()
        self.complaints: list[str] = []
        self.said: list[str] = []
        """Standard error of every service process that has ended."""
        self.service = self._start_service()

    def api(self) -> httpx2.Client:
        """A client of the present service process; the caller closes it.

        :raises NotReady: if it does not start.
        """
        return self.service.api()

    def start(self) -> None:
        """Inject faults until `pause`."""
        self._background = Background("faults", self._run)
        self._background.start()

    def pause(self) -> None:
        """Stop injecting faults; returns when the service is up, or has failed to start."""
        if self._background is not None:
            self._background.end()
            self._background = None
        with self._lock:
            self._record_death()
            self._wait_until_up()

    def end(self) -> None:
        """Stop the service as an operator would."""
        with self._lock:
            self.service.end()
            self.said.append(self.service.stderr)

    def kill(self) -> None:
        """Kill the service."""
        self.service.kill()

    def _run(self) -> None:
        assert self._background is not None
        ending = self._background.ending
        while not ending.wait(self._rng.uniform(*PAUSE_S)):
            with self._lock:
                self._record_death()
                kind = self._rng.choices(list(KINDS), list(KINDS.values()))[0]
                if self._inject(kind):
                    self.done[kind] += 1
                self._wait_until_up()

    def _inject(self, kind: str) -> bool:
        """False if there was no process to inject it into."""
        match kind:
            case "simulation killed":
                return self._kill_simulation()
            case "planning killed":
                return self._kill_one(self.service.planners())
            case "service stopped for 2 s":
                self._suspend()
            case "service restarted":
                self._wait_until_up()
                self.service.end()
                self._restart()
            case "service killed during its start":
                self.service.kill()
                self._restart()
                pause(self._clock, self._rng.uniform(0.3, 4.0))
                self.service.kill()
                self._restart()
            case _:
                self.service.kill()
                self._restart()
        return True

    def _kill_simulation(self) -> bool:
        simulation = self.service.simulation()
        now_s = self._clock.monotonic_s()
        if simulation is None or now_s - self._simulation_killed_s < SIMULATION_PAUSE_S:
            return False
        self._simulation_killed_s = now_s
        return self._kill_one([simulation])

    def _kill_one(self, candidates: list[Running]) -> bool:
        if candidates:
            kill([self._rng.choice(candidates)])
        return bool(candidates)

    def _suspend(self) -> None:
        self.service.process.send_signal(signal.SIGSTOP)
        pause(self._clock, STOPPED_S)
        self.service.process.send_signal(signal.SIGCONT)

    def _restart(self) -> None:
        self.said.append(self.service.stderr)
        if injected := self._world_fault(self._rng):
            self.done[injected] += 1
        self.service = self._start_service()

    def _start_service(self) -> ServiceProcess:
        self._starts += 1
        return self._installation.start(self._starts)

    def _record_death(self) -> None:
        """Record it as a failure if the service has ended by itself, and restart it."""
        if not self.service.is_alive:
            status = self.service.process.returncode
            self.complaints.append(f"service process {self.service.number} ended by itself ({status})")
            self._restart()

    def _wait_until_up(self) -> None:
        try:
            self.service.address()
        except NotReady as error:
            self.complaints.append(str(error))
