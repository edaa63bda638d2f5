"""A world whose robots do what their own rules say: reports of own packets, beliefs, contacts and what is said."""

from collections.abc import Callable, Sequence
from itertools import combinations
from types import TracebackType
from typing import Self

from robots.deliberative.reader import beliefs_of
from robots.deliberative.terms import Term
from robots.physical.body import RADIUS_M
from robots.wire import Message, Performative, Receipt, UpkeepReport
from robots.world import LinkSpec, WorldFile, load_world
from sim.clock import CONTROL_S
from sim.snapshot import WorldSnapshot
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation

CYCLES_A_SECOND = round(1 / CONTROL_S)
MEET_M = 0.02
"""Hulls this near have met."""


class Stage:
    """A demonstration's world; `step` advances it by a control cycle."""

    def __init__(self, name: str, *, seed: int, loss: float = 0.0, jitter_m: float = 0.4) -> None:
        """:param loss: the share of the messages between robots that is lost."""
        world = load_world(name)
        link = (world.peer_link or LinkSpec()).model_copy(update={"loss": loss})
        self.world: WorldFile = world.model_copy(update={"peer_link": link})
        self.simulation = Simulation(self.world, make_agent=behavioural_agent, seed=seed, jitter_m=jitter_m)
        self.reports: list[tuple[str, UpkeepReport]] = []
        """Of own packets, with the robot's name, in the order of arrival."""
        self.touches: dict[str, int] = {}
        """Robot → how often it has begun to press against something."""
        self.nearest_m = float("inf")
        """The least distance between two robots' hulls so far; negative if they have overlapped."""
        self.meetings = 0
        """How often two robots' hulls have met."""
        self._meeting: set[tuple[str, str]] = set()
        self.watch: Callable[[], None] = lambda: None
        """Called after each control cycle."""
        self._pressing: set[str] = set()
        self._seen: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.simulation.close()

    def restart(self) -> None:
        """End the world and resume it from its snapshot, as after a power failure; messages under way are lost."""
        snapshot = WorldSnapshot.model_validate_json(self.simulation.snapshot().model_dump_json())
        self.simulation.close()
        self.simulation = Simulation(self.world, make_agent=behavioural_agent, snapshot=snapshot)

    @property
    def now_s(self) -> float:
        return self.simulation.clock.now_s()

    def step(self) -> None:
        """One control cycle."""
        self.simulation.step_control_cycle()
        self._receive()
        pressing = {name for name, body in self.simulation.bodies.items() if body.touches()}
        for name in pressing - self._pressing:
            self.touches[name] = self.touches.get(name, 0) + 1
        self._pressing = pressing
        gaps_m = {
            (one, other): abs(at - to) - 2 * RADIUS_M
            for (one, at), (other, to) in combinations(self.places().items(), 2)
        }
        self.nearest_m = min(self.nearest_m, *gaps_m.values())
        meeting = {pair for pair, gap_m in gaps_m.items() if gap_m < MEET_M}
        self.meetings += len(meeting - self._meeting)
        self._meeting = meeting
        self.watch()

    def run_until(self, done: Callable[[], bool], *, timeout_s: float) -> bool:
        """Step until `done`, checked once a second, or the timeout; True if done."""
        end_s = self.now_s + timeout_s
        while not done():
            if self.now_s >= end_s:
                return False
            for _ in range(CYCLES_A_SECOND):
                self.step()
        return True

    def places(self) -> dict[str, complex]:
        """Robot → where it truly is, x + jy, metres."""
        return {name: complex(pose.x_m, pose.y_m) for name, pose in self.simulation.truth().robots.items()}

    def beliefs(self, robot: str) -> Sequence[Term]:
        """What the robot's agents have adopted."""
        memory = self.simulation.agents[robot].memory().mind.rules  # type: ignore[attr-defined]
        return [one for texts in memory.beliefs.values() for one in beliefs_of(texts)]

    def is_believed(self, robot: str, functor: str) -> bool:
        return any(one.functor == functor for one in self.beliefs(robot))

    def _receive(self) -> None:
        for message in self.simulation.link.receive():
            if not isinstance(message.body, UpkeepReport):
                continue
            self.simulation.link.send(
                Message(
                    performative=Performative.CONFIRM,
                    sender="service",
                    receiver=message.sender,
                    sent_at_s=self.now_s,
                    in_reply_to=message.id,
                    body=Receipt(),
                )
            )
            if message.id not in self._seen:
                self._seen.add(message.id)
                self.reports.append((message.sender, message.body))
