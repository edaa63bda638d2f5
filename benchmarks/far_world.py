"""A simulated world in a thread of this process, with radios that its robots are reached through: for benchmarks."""

import threading
from collections.abc import Callable, Mapping
from typing import Self

from app.composition import RunningWorld
from robots.link import InMemoryLink
from robots.world import WorldFile
from sim.clock import TICKS_PER_CONTROL, WallClock
from sim.process.pacing import Pacer
from sim.world.agent import AgentFactory
from sim.world.agents import behavioural_agent
from sim.world.hub import Hub
from sim.world.radio import Radio
from sim.world.simulation import Simulation

RATE = 20.0
"""World seconds a second, if the machine can."""
NAP_S = 0.002


class FarWorld:
    """Runs during a `with` block; `running` is the service's access to it.

    :param meanwhile: called at 20 Hz, between two ticks, in the world's thread.
    """

    def __init__(
        self,
        world: WorldFile,
        *,
        seed: int,
        radios: Mapping[str, Radio],
        rate: float = RATE,
        make_agent: AgentFactory = behavioural_agent,
        meanwhile: Callable[[Simulation], None] = lambda _: None,
    ) -> None:
        link, far = InMemoryLink.pair()
        hub = Hub(far, list(radios), telemetry_gap_s=0.05, wall_clock=WallClock(), radios=radios)
        self.simulation = Simulation(world, make_agent=make_agent, seed=seed, jitter_m=0.0, hub=hub)
        self.running = RunningWorld(
            file=world, link=link, clock=self.simulation.clock, rate=rate, run=self.simulation.run
        )
        self._meanwhile = meanwhile
        self._pacer, self._stop = Pacer(WallClock(), rate), threading.Event()
        self._thread = threading.Thread(target=self._run, name="far world", daemon=True)
        self.error: BaseException | None = None
        """The exception that ended the world early."""

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()
        self.simulation.close()

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                self._advance()
        except Exception as error:  # raised where the mission is awaited
            self.error = error

    def _advance(self) -> None:
        clock = self.simulation.clock
        wait_s = self._pacer.wait_s(clock.now_s()) or 0.0
        if wait_s > 0:
            self._stop.wait(max(wait_s, NAP_S))
            return
        if clock.ticks % TICKS_PER_CONTROL == 0:
            self._meanwhile(self.simulation)
        self.simulation.step()
