"""What a condition is, and what it answers."""

from dataclasses import dataclass
from typing import Protocol

from robots.perception.percepts import Needs, Percepts


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a condition holds, and what was perceived, in words.

    `unseen`: it does not hold for want of sight, neither what it asks about nor the place of it is in view.
    """

    holds: bool
    words: str
    unseen: bool = False


class Condition(Protocol):
    """A question to the senses. `needs`: the sensors whose percepts it asks for."""

    @property
    def needs(self) -> Needs: ...

    def check(self, percepts: Percepts) -> Verdict: ...
