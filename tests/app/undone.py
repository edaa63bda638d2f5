"""Workflows that nobody carries out: who was taken over from is noted."""

from dataclasses import dataclass, field
from math import inf


@dataclass
class Noted:
    """Says for `executor` that it took over, and nothing more."""

    executor: str
    taken_over: list[tuple[str, str]] = field(default_factory=list)
    """Who took over from whom."""
    begins_until: float = inf

    def may_begin(self, until: float) -> None:
        self.begins_until = until

    def take_over(self, executor: str) -> int:
        self.taken_over.append((self.executor, executor))
        return 1

    def take_up(self) -> int:
        return 0
