"""Workflows that nobody carries out: whose workflows were recovered is noted."""

from dataclasses import dataclass, field
from math import inf

from sqlalchemy.orm import Session


@dataclass
class Noted:
    """Notes for `executor` that it recovered the workflows of others, and does nothing more."""

    executor: str
    recovered: list[tuple[str, str]] = field(default_factory=list)
    """Who recovered from whom."""
    dequeues_until: float = inf

    def dequeue_until(self, monotonic_s: float) -> None:
        self.dequeues_until = monotonic_s

    def recover_executor(self, session: Session, executor: str) -> int:
        self.recovered.append((self.executor, executor))
        return 1

    def recover_lost(self) -> int:
        return 0
