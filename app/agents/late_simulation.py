"""A simulated world that is built while the service already knows it: a link and a clock from the beginning."""

import logging
import threading
from collections.abc import Callable, Sequence
from typing import Protocol

from app.domain.errors import MactaError
from robots.clock import Clock
from robots.link import Link, LinkClosed
from robots.wire import Message

CLOSE_S = 5.0
"""How long `close` waits for a simulation that is still being built; it is ended as soon as it is."""

logger = logging.getLogger(__name__)


class Simulation(Link, Clock, Protocol):
    """A running simulation, paused."""

    @property
    def run(self) -> str: ...

    @property
    def not_resumed_because(self) -> str: ...

    def pause(self, paused: bool = True) -> None: ...

    def stop(self) -> None: ...


class LateSimulation:
    """Implements `robots.link.Link`, `robots.clock.Clock` and `Driver` for a simulation that a thread starts.

    Until its run is taken up, no message passes. Until it is built, its clock stands still. Thread-safe.
    """

    def __init__(
        self, name: str, start: Callable[[Callable[[str], None]], Simulation], *, began_s: float = 0.0
    ) -> None:
        """
        :param start: starts the simulation, paused, and returns once it is built; it is given what tells the progress,
            and raises `MactaError` if the world cannot be built.
        :param began_s: what the clock shows until then: the last time that is known of a world that is resumed.
        """
        self._name = name
        self._start = start
        self._began_s = began_s
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._simulation: Simulation | None = None
        self._closed = False
        self._run: str | None = None
        self._taken_up: str | None = None
        self.failure = ""
        """Why it could not be built, in words."""
        self.doing = "the simulation is being built"
        """What its start is doing, in words."""
        self._thread = threading.Thread(target=self._build, name=f"start-{name}", daemon=True)
        self._thread.start()

    def _build(self) -> None:
        try:
            simulation = self._start(self._tell)
        except MactaError as error:
            self._fail(error.detail)
            return
        except Exception:
            logger.exception("the start of world %s failed", self._name)
            self._fail("its start failed; the service's log says why")
            return
        with self._lock:
            is_wanted = not self._closed
            if is_wanted:
                self._simulation = simulation
                self._run = simulation.run
        if not is_wanted:
            simulation.stop()

    def _tell(self, doing: str) -> None:
        self.doing = doing

    def _fail(self, why: str) -> None:
        logger.error("world %s cannot be started: %s", self._name, why)
        self.failure = why.strip().splitlines()[-1]  # it may be a traceback
        self._changed.set()

    @property
    def simulation(self) -> Simulation | None:
        """None before it is built."""
        return self._simulation

    @property
    def run(self) -> str | None:
        """The run of the simulation, None before it is built."""
        return self._run

    @property
    def taken_up(self) -> str | None:
        return self._taken_up

    def take_up(self, run: str) -> None:
        """Let messages pass from now on, and the simulation continue."""
        simulation = self._simulation
        assert simulation is not None
        self._taken_up = run
        simulation.pause(False)
        self._changed.set()

    @property
    def new_run_reason(self) -> str:
        """Why a new run was started, if an earlier one might have been resumed."""
        return "" if self._simulation is None else self._simulation.not_resumed_because

    def now_s(self) -> float:
        return self._began_s if self._simulation is None else self._simulation.now_s()

    def send(self, message: Message) -> None:
        """Dropped before the run is taken up, as by radio."""
        if self._simulation is not None and self._taken_up is not None:
            self._simulation.send(message)

    def receive(self, timeout_s: float = 0.0) -> Sequence[Message]:
        """:raises LinkClosed: if the simulation could not be built, or has ended for good."""
        if self.failure or self._closed:
            raise LinkClosed(self.failure or "the world was removed")
        if self._simulation is None or self._taken_up is None:
            self._changed.wait(timeout_s)
            return ()
        return self._simulation.receive(timeout_s)

    def close(self) -> None:
        """End the simulation and wait for its end; safe to call again."""
        with self._lock:
            self._closed = True
            simulation = self._simulation
        self._changed.set()
        if simulation is not None:
            simulation.stop()
        self._thread.join(CLOSE_S)
