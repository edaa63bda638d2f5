"""The worlds that run in this process, each with the agent models that speak for it."""

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar

from app.agents.agent_models import AgentModels
from app.agents.running_world import RunningWorld
from app.domain.errors import UnknownWorld

Value = TypeVar("Value")


class RunningWorlds(Mapping[str, RunningWorld]):
    """Worlds by name; they come and go while the service runs, and are read at any time. Thread-safe.

    A world that comes is known by `add`, exchanges messages from `start` on, and continues its run from `resume` on:
    in between, all parts of the service get to know it.
    """

    def __init__(
        self,
        worlds: Iterable[RunningWorld],
        *,
        agents: Callable[[RunningWorld], AgentModels],
        listen: Callable[[RunningWorld], None],
    ) -> None:
        """
        :param agents: makes the agent models of a world, when it starts.
        :param listen: starts to receive from the world's fleet, likewise.
        """
        self._worlds = {world.file.name: world for world in worlds}
        self._agents_of = agents
        self._listen = listen
        self._agents: dict[str, AgentModels] = {}
        self._lock = threading.Lock()
        self.unknown: Callable[[], None] = lambda: None
        """Called before a name counts as unknown: another process may have added the world just now."""

    def __getitem__(self, name: str) -> RunningWorld:
        if name not in self._worlds:
            self.unknown()
        try:
            return self._worlds[name]
        except KeyError:
            raise UnknownWorld(name, self._worlds) from None

    def __contains__(self, name: object) -> bool:
        return name in self._worlds

    def __iter__(self) -> Iterator[str]:
        return iter(self._worlds)

    def __len__(self) -> int:
        return len(self._worlds)

    def each(self, of: Callable[[RunningWorld], Value]) -> Mapping[str, Value]:
        """By world, what a function makes of it now."""
        return _Each(self, of)

    def add(self, world: RunningWorld) -> None:
        with self._lock:
            self._worlds = {**self._worlds, world.file.name: world}

    def start(self, name: str) -> None:
        """Exchange messages with the world's robots."""
        world = self._worlds[name]
        agents = self._agents_of(world)
        with self._lock:
            self._agents[name] = agents
        self._listen(world)
        agents.start()

    def resume(self, name: str) -> None:
        """Let a simulated world continue, once the service receives messages."""
        self._worlds[name].resume()

    def stop(self, name: str) -> None:
        """End the exchange of messages with the world's robots."""
        with self._lock:
            agents = self._agents.pop(name, None)
        if agents is not None:
            agents.close()

    def remove(self, name: str) -> RunningWorld:
        """Know the world no longer, after `stop`; returns it, to be closed."""
        with self._lock:
            world = self._worlds[name]
            self._worlds = {one: known for one, known in self._worlds.items() if one != name}
        return world

    def close(self) -> None:
        """End the exchange of messages with all worlds."""
        for name in tuple(self._agents):
            self.stop(name)

    def end(self) -> None:
        """End what drives the worlds, as far as it belongs to this process; after `close`."""
        for world in self._worlds.values():
            world.close()


class _Each(Mapping[str, Value]):
    def __init__(self, worlds: RunningWorlds, of: Callable[[RunningWorld], Value]) -> None:
        self._worlds = worlds
        self._of = of

    def __getitem__(self, name: str) -> Value:
        return self._of(self._worlds[name])

    def __contains__(self, name: object) -> bool:
        return name in self._worlds

    def __iter__(self) -> Iterator[str]:
        return iter(self._worlds)

    def __len__(self) -> int:
        return len(self._worlds)
