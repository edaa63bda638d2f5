"""Results of a sweep: each seed's outcome, the success rate with its interval, times, and failures by kind."""

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import sqrt
from statistics import median

NUMBER = re.compile(r"-?\d+(\.\d+)?")
Z_95 = 1.959964


class Outcome(StrEnum):
    """How one seed's mission ended."""

    CAME_TRUE = "came_true"
    """The goals are true in the simulated world, and every robot has finished."""
    FAILED = "failed"
    """A robot reported a failure, or refused its script."""
    UNTRUE = "untrue"
    """All robots have finished, but a goal is not true."""
    UNENDED = "unended"
    """No robot failed, but not all ended in time."""
    UNPLANNED = "unplanned"
    """There was nothing to execute: no possible goal, no plan, or no scripts. Counted separately."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeedResult:
    """A seed's goal and outcome.

    `took_s` is the world's time until the last robot had ended, `estimate_s` the plan's; both None without a plan.
    `packet` is the tag of the packet that failed, `reason` the robot's reason, or why there is no plan.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Median and extremes of some figures."""

    median: float
    least: float
    most: float

    @classmethod
    def of(cls, figures: Sequence[float]) -> "Spread | None":
        """The spread of the figures; None if there are none."""
        return cls(median=median(figures), least=min(figures), most=max(figures)) if figures else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Seeds with the same outcome and packet, and the same reason except for numbers in it."""

    outcome: Outcome
    packet: str | None
    reason: str
    seeds: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepSummary:
    """`tried` missions had scripts; the rate is of them, with its 95 % interval (Wilson's score).

    `took_s` and `ratio` (time taken over estimated) are of those that came true. Groups: the most frequent first.
    """

    seeds: int
    tried: int
    came_true: int
    interval: tuple[float, float] | None
    took_s: Spread | None
    ratio: Spread | None
    failures: tuple[Group, ...]
    unplanned: tuple[Group, ...]

    @classmethod
    def of(cls, rows: Sequence[SeedResult]) -> "SweepSummary":
        tried = [row for row in rows if row.outcome is not Outcome.UNPLANNED]
        true = [row for row in tried if row.outcome is Outcome.CAME_TRUE]
        return cls(
            seeds=len(rows),
            tried=len(tried),
            came_true=len(true),
            interval=wilson(len(true), len(tried)) if tried else None,
            took_s=Spread.of([row.took_s for row in true if row.took_s is not None]),
            ratio=Spread.of([row.ratio for row in true if row.ratio is not None]),
            failures=_grouped([row for row in tried if row.outcome is not Outcome.CAME_TRUE]),
            unplanned=_grouped([row for row in rows if row.outcome is Outcome.UNPLANNED]),
        )

    @property
    def rate(self) -> float | None:
        return self.came_true / self.tried if self.tried else None


def wilson(good: int, of: int) -> tuple[float, float]:
    """The 95 % score interval of a share (Wilson 1927).

    :param of: at least 1.
    """
    share = good / of
    weight = Z_95**2 / of
    middle = (share + weight / 2) / (1 + weight)
    half = Z_95 * sqrt(share * (1 - share) / of + weight / (4 * of)) / (1 + weight)
    return max(0.0, middle - half), min(1.0, middle + half)


def _grouped(rows: Sequence[SeedResult]) -> tuple[Group, ...]:
    """The groups of the rows; each group's reason is that of its first seed."""
    groups: dict[tuple[Outcome, str | None, str], list[SeedResult]] = defaultdict(list)
    for row in rows:
        groups[row.outcome, row.packet, NUMBER.sub("#", row.reason)].append(row)
    return tuple(
        Group(outcome=outcome, packet=packet, reason=alike[0].reason, seeds=tuple(r.seed for r in alike))
        for (outcome, packet, _), alike in sorted(groups.items(), key=lambda item: -len(item[1]))
    )
