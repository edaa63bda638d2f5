"""How one seed's mission ended."""

from dataclasses import dataclass
from enum import StrEnum


class Outcome(StrEnum):
    CAME_TRUE = "came_true"
    """In the simulated world itself, and every robot says that it has finished."""
    FAILED = "failed"
    """A robot reported a failure, or refused its script."""
    UNTRUE = "untrue"
    """All robots say that they have finished, but a goal is not true."""
    UNENDED = "unended"
    """No robot failed, but they did not come to an end."""
    UNPLANNED = "unplanned"
    """There was nothing to carry out: no goal that the world can take, no plan, or no scripts. Counted apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A seed: what was to become true, and whether it did.

    `took_s` is the world's time until the last robot had ended, `estimate_s` the plan's; both None without a plan.
    `packet` is the tag of the packet that failed, `reason` what the robot said, or why there is no plan.
    """

    seed: int
    goal: str
    outcome: Outcome
    took_s: float | None = None
    estimate_s: float | None = None
    packet: str | None = None
    reason: str = ""

    @property
    def ratio(self) -> float | None:
        """Time taken over time estimated; None if either is missing or nothing had to be done."""
        return self.took_s / self.estimate_s if self.took_s is not None and self.estimate_s else None
