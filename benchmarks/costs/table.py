"""Rows of the table of costs."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

WIDTH = 66
HEADING = f"{'what':{WIDTH}s} {'median':>9s} {'min to max':>17s} {'before':>9s} {'target':>9s}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A measured figure.

    :param target: the most that it may be, or the least if `more_is_better`; None without one.
    :param before: what it was before it was worked on, if that was measured.
    """

    what: str
    unit: str
    values: Sequence[float]
    target: float | None = None
    before: str = ""
    more_is_better: bool = False

    @property
    def is_met(self) -> bool | None:
        """True if the median meets the target; None without one."""
        if self.target is None:
            return None
        middle = median(self.values)
        return middle >= self.target if self.more_is_better else middle <= self.target

    def __str__(self) -> str:
        spread = f"{_short(min(self.values))} to {_short(max(self.values))}"
        sign = "≥" if self.more_is_better else "≤"
        target = "" if self.target is None else f"{sign} {_short(self.target)}"
        verdict = {True: "met", False: "not met", None: ""}[self.is_met]
        what = f"{self.what}, {self.unit}"
        return (
            f"{what:{WIDTH}s} {_short(median(self.values)):>9s} {spread:>17s} {self.before:>9s} {target:>9s}"
            f"  {verdict}".rstrip()
        )


def _short(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.1f}" if abs(value) >= 10 else f"{value:.2f}"
