"""The interface to the deliberative level above: it may act on the executive in each tick, and asks for sensors."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from robots.executive.breakpoints import HeldFiring
from robots.executive.executive import Executive
from robots.executive.mind_memory import MindMemory
from robots.perception.percepts import Needs, Percepts
from robots.wire import ToldAgent, ToldMessage


class Deliberation(Protocol):
    """The robot's own rules."""

    @property
    def needs(self) -> Needs:
        """The sensors that they need now, which the robot has."""
        ...

    @property
    def charges(self) -> bool:
        """True if they say when the robot seeks its charger."""
        ...

    @property
    def takes_over(self) -> frozenset[str]:
        """The packets' events on which they act in place of the packets' own retries and limits."""
        ...

    def cycle(self, executive: Executive, percepts: Percepts | None, now_s: float) -> None:
        """One tick. `percepts`: None during a sensor fault."""
        ...

    @property
    def version(self) -> int:
        """Of the rules that were sent last."""
        ...

    @property
    def digests(self) -> Mapping[str, str]:
        """Of the rule files in use, by name."""
        ...

    @property
    def role(self) -> str:
        """What the robot plays; empty: no role."""
        ...

    def told(self) -> tuple[ToldAgent, ...]:
        """What its agents believe and are committed to, in order of rank."""
        ...

    @property
    def told_messages(self) -> tuple[ToldMessage, ...]:
        """What was said to the robot and nothing but its rules may take, the last ones, oldest first."""
        ...

    def break_at(self, rules: frozenset[str]) -> None:
        """Hold back what these rules, "guard:3" and the like, commit to until the next tick."""
        ...

    @property
    def held(self) -> Sequence[HeldFiring]:
        """What is held back until the next tick."""
        ...

    def follow(self, files: Mapping[str, str], version: int, now_s: float, role: str = "") -> str | None:
        """Follow these rule files in this role, or return the reason against them; then the present ones stay."""
        ...

    def memory(self) -> MindMemory:
        """The state to restore after a power failure."""
        ...

    def hand_over(self) -> MindMemory:
        """The state with all beliefs and commitments, for another program that goes on from there."""
        ...

    def recall(self, memory: MindMemory, now_s: float) -> None:
        """Restore it. Rules that the robot can no longer follow are left out."""
        ...
