"""What befalls the service: its processes are killed at any instant, all at once or one alone, and begun again."""

import random
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable

import httpx2

from app.background import Background
from app.plans.tree import Running, kill
from app.trials.service_process import Installation, Life, NotReady

Mishap = Callable[[random.Random], str]
"""Something befalls the world while no service runs; says what, or nothing if nothing did."""

KINDS = {
    "service killed": 4,
    "service killed as it began": 2,
    "service ended and begun again": 1,
    "simulation killed": 3,
    "planning killed": 3,
    "service stopped for 2 s": 1,
}
"""Each with its share."""
PAUSE_S = (2.0, 15.0)
STOPPED_S = 2.0
SIMULATION_PAUSE_S = 25.0
"""A world whose process dies more often than five times in two minutes is given up by the service: that is no fault."""


class Faults:
    """Keeps the present life of the service, and ends it now and then in a thread of its own. Thread-safe."""

    def __init__(self, installation: Installation, seed: int, mishap: Mishap = lambda _: "") -> None:
        self._installation, self._rng, self._mishap = installation, random.Random(seed), mishap
        self._lock = threading.Lock()
        self._lives = 0
        self._simulation_killed_at = float("-inf")
        self._background: Background | None = None
        self.done: Counter[str] = Counter()
        self.complaints: list[str] = []
        self.said: list[str] = []
        """What every life that is over wrote to standard error."""
        self.life = self._begin()

    def api(self) -> httpx2.Client:
        """A client of the present life; the caller closes it.

        :raises NotReady: if it does not come up.
        """
        return self.life.api()

    def start(self) -> None:
        """Let faults happen until `pause`."""
        self._background = Background("faults", self._run)
        self._background.start()

    def pause(self) -> None:
        """No more faults; answers once the service is up, if it is to come up at all."""
        if self._background is not None:
            self._background.end()
            self._background = None
        with self._lock:
            self._note_death()
            self._wait_until_up()

    def end(self) -> None:
        """The last life ends as an operator would end it."""
        with self._lock:
            self.life.end()
            self.said.append(self.life.complaints)

    def kill(self) -> None:
        """The last life ends at once, whatever it is at."""
        self.life.kill()

    def _run(self) -> None:
        assert self._background is not None
        ending = self._background.ending
        while not ending.wait(self._rng.uniform(*PAUSE_S)):
            with self._lock:
                self._note_death()
                kind = self._rng.choices(list(KINDS), list(KINDS.values()))[0]
                if self._befall(kind):
                    self.done[kind] += 1
                self._wait_until_up()

    def _befall(self, kind: str) -> bool:
        """False if there was nothing to do it to."""
        match kind:
            case "simulation killed":
                return self._kill_simulation()
            case "planning killed":
                return self._kill_one(self.life.planners())
            case "service stopped for 2 s":
                self._stop_for_a_while()
            case "service ended and begun again":
                self._wait_until_up()
                self.life.end()
                self._begin_again()
            case "service killed as it began":
                self.life.kill()
                self._begin_again()
                time.sleep(self._rng.uniform(0.3, 4.0))
                self.life.kill()
                self._begin_again()
            case _:
                self.life.kill()
                self._begin_again()
        return True

    def _kill_simulation(self) -> bool:
        simulation = self.life.simulation()
        if simulation is None or time.monotonic() - self._simulation_killed_at < SIMULATION_PAUSE_S:
            return False
        self._simulation_killed_at = time.monotonic()
        return self._kill_one([simulation])

    def _kill_one(self, candidates: list[Running]) -> bool:
        if candidates:
            kill([self._rng.choice(candidates)])
        return bool(candidates)

    def _stop_for_a_while(self) -> None:
        self.life.process.send_signal(signal.SIGSTOP)
        time.sleep(STOPPED_S)
        self.life.process.send_signal(signal.SIGCONT)

    def _begin_again(self) -> None:
        self.said.append(self.life.complaints)
        if befallen := self._mishap(self._rng):
            self.done[befallen] += 1
        self.life = self._begin()

    def _begin(self) -> Life:
        self._lives += 1
        return self._installation.begin(self._lives)

    def _note_death(self) -> None:
        """A life that ended by itself is a fault of the service's own."""
        if not self.life.is_alive:
            status = self.life.process.returncode
            self.complaints.append(f"life {self.life.number} of the service ended by itself ({status})")
            self._begin_again()

    def _wait_until_up(self) -> None:
        try:
            self.life.address()
        except NotReady as error:
            self.complaints.append(str(error))
