"""Worlds that are added in tests: copies of the sample store under other names, and fake teams that drive them."""

import json
import threading
from collections.abc import Callable

from app.agents.late_simulation import LateSimulation
from app.agents.running_world import RunningWorld
from app.domain.errors import Unavailable
from robots.link import LinkClosed
from robots.wire import Message
from robots.world import WorldFile, load_world
from tests.app.fake_robots import FakeTeam


def hall(name: str, *, robots: str | None = None, title: str = "") -> WorldFile:
    """The sample store as another world.

    :param robots: what their names begin with; None: the world's name.
    """
    store = load_world("sample_store")
    text = json.dumps(store.model_dump(mode="json"))
    for robot in store.robots:
        text = text.replace(f'"{robot.name}"', f'"{robots or name}_{robot.name}"')
    return WorldFile.model_validate({**json.loads(text), "name": name, "title": title})


class TeamSimulation:
    """A fake team as the simulation that a host starts."""

    def __init__(self, team: FakeTeam) -> None:
        self.team = team
        self.run = team.run
        self.not_resumed_because = ""
        self.paused = True
        self.stopped = False

    def pause(self, paused: bool = True) -> None:
        self.paused = paused

    def now_s(self) -> float:
        return self.team.clock.now_s()

    def send(self, message: Message) -> None:
        self.team.link.send(message)

    def receive(self, timeout_s: float = 0.0) -> list[Message]:
        if self.stopped:
            raise LinkClosed("the team has gone")
        return list(self.team.link.receive(timeout_s))

    def close(self) -> None: ...

    def stop(self) -> None:
        if not self.stopped:
            self.stopped = True
            self.team.__exit__()


class TeamHost:
    """Starts a fake team for each world that is added; implements `WorldHost`."""

    def __init__(self, *, simulates: bool = True) -> None:
        self.simulates = simulates
        self.built = threading.Event()
        """Simulations are built while it is set, as it is from the beginning."""
        self.built.set()
        self.broken: set[str] = set()
        """Worlds that cannot be built."""
        self.simulations: dict[str, TeamSimulation] = {}
        self.rates: dict[str, float | None] = {}
        self.forgotten: list[str] = []
        self.runs: dict[str, str] = {}
        """The runs of worlds that are resumed."""

    def open(self, file: WorldFile, *, rate: float | None) -> RunningWorld:
        self.rates[file.name] = rate
        late = LateSimulation(file.name, lambda tell: self._start(file, tell))
        return RunningWorld(
            file=file, link=late, clock=late, rate=None, run=None, late=late, close=late.close
        )

    def _start(self, file: WorldFile, tell: Callable[[str], None]) -> TeamSimulation:
        tell("the team gets up")
        self.built.wait()
        if file.name in self.broken:
            raise Unavailable(f"{file.name} cannot be built")
        team = FakeTeam(run=self.runs.setdefault(file.name, f"run of {file.name}"))
        team.__enter__()
        self.simulations[file.name] = TeamSimulation(team)
        return self.simulations[file.name]

    def forget(self, file: WorldFile) -> None:
        self.forgotten.append(file.name)
        self.runs.pop(file.name, None)
