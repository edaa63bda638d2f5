"""Cursors: symbols anchored in what is perceived (SRA; Coradeschi & Saffiotti 2001)."""

from dataclasses import dataclass
from math import exp2, inf

MOVING_S = 1.5
"""A thing that left its place this long ago and not again stands still."""
HALF_LIFE_S = 2.0
"""Evidence that nothing renews halves in this time (our choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cursor:
    """A thing as it is believed to be. World frame, metres; times on the robot's clock, seconds.

    `at` and `velocity` are filtered, as of `seen_s`; `evidence` in [0, 1], as of then; `variance_m2` of the place.
    `viewed_s`: last in infra-red; `in_view_since_s`: there without a break. `anchor`: where it was when it was last
    found to have moved; `rest` and `moved_s`: where it was filtered, and when that last left there.
    """

    at: complex
    seen_s: float
    viewed_s: float = -inf
    in_view_since_s: float
    anchor: complex
    still_since_s: float
    velocity: complex = 0j
    evidence: float = 0.0
    variance_m2: float = 1.0
    rest: complex = 0j
    moved_s: float = -inf

    def moving_at(self, now_s: float) -> bool:
        """True while it does not keep its place."""
        return now_s - self.moved_s <= MOVING_S

    def evidence_at(self, now_s: float) -> float:
        """What is left of its evidence."""
        return self.evidence * exp2(-max(0.0, now_s - self.seen_s) / HALF_LIFE_S)
