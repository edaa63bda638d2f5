"""What a condition is, and what it answers."""

from dataclasses import dataclass
from typing import Protocol

from robots.percepts import Percepts


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a condition holds, and what was perceived, in words."""

    holds: bool
    words: str


class Condition(Protocol):
    """A question to the senses."""

    def check(self, percepts: Percepts) -> Verdict: ...
