"""What a world asks of a robot's on-board software, and what it gives it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from robots.clock import Clock
from robots.executive.breakpoints import Halt
from robots.executive.hand_over import MindDocument
from robots.executive.memory import BodyMemory, RobotMemory
from robots.link import Link
from robots.physical.body import Body, Pose
from robots.wire import Factsheet, Program
from robots.world import Location, RobotSpec, Zone


class Agent(Protocol):
    """A robot's on-board software, driven by the world's clock at 20 Hz."""

    def tick(self) -> None: ...


@runtime_checkable
class HasMemory(Protocol):
    """An agent that can be resumed after a restart."""

    def memory(self, *, is_whole: bool = False) -> RobotMemory:
        """:param is_whole: with what does not outlive a power failure."""
        ...


@runtime_checkable
class HasRules(Protocol):
    """An agent whose rules may have breakpoints."""

    def break_at(self, rules: frozenset[str]) -> None: ...

    @property
    def is_held(self) -> bool: ...

    def halt_report(self) -> Halt: ...


@runtime_checkable
class TellsOfItself(Protocol):
    """An agent that goes on in another body, and tells what it is then."""

    def announce(self, factsheet: Factsheet) -> None: ...


@runtime_checkable
class TakesMinds(Protocol):
    """An agent that can go on with a mind that another program hands over."""

    def take_over(self, document: MindDocument, *, body: BodyMemory | None) -> str | None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSetup:
    """What an agent is made with: its spec, the locations of its reach, the names of the other robots and of the known
    samples, the zones, the lengths of long samples, the pose it is told, its radio's round trip, its interfaces, the
    memory it resumes with, and the number of the world's edition. `speaks`: it has a social level. `program`: that
    runs it.
    """

    spec: RobotSpec
    reach: tuple[Location, ...]
    others: tuple[str, ...]
    samples: frozenset[str]
    zones: tuple[Zone, ...]
    lengths_m: Mapping[str, float]
    told: Pose
    round_trip_s: float
    body: Body
    link: Link
    clock: Clock
    memory: RobotMemory | None = None
    edition: int = 0
    speaks: bool = False
    program: Program = Program.WORLD
    peer_round_trip_s: float = 0.0

    @property
    def factsheet(self) -> Factsheet:
        """What the robot tells of itself."""
        spec = self.spec
        return Factsheet(
            body=spec.body.model_dump(mode="json"),
            sensors=tuple(sensor.model_dump(mode="json") for sensor in spec.sensors),
            senses=spec.senses,
            speaks=spec.speaks,
            repertoire=spec.repertoire,
            speed_m_s=spec.speed_m_s,
            turn_rad_s=spec.turn_rad_s,
            compartment=spec.compartment,
            aisle=spec.aisle,
            home=spec.home,
            edition=self.edition,
        )

    def is_for_the_same_software(self, other: "AgentSetup") -> bool:
        """True if software made with the other can go on with this: what differs concerns its body alone."""
        kept = {"body": other.spec.body, "sonar": other.spec.sonar}
        mine = replace(
            self,
            spec=self.spec.model_copy(update=kept),
            told=other.told,
            body=other.body,
            link=other.link,
            clock=other.clock,
            memory=other.memory,
            edition=other.edition,
        )
        return mine == other


AgentFactory = Callable[[AgentSetup], Agent]
