"""The figures as a table: one row a family and size, medians over seeds, the other engines to the right."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import log
from statistics import linear_regression, median

from benchmarks.planner.measure import OURS, Measure

GROWTH_FROM = 16
GROWTH_TO = 256


@dataclass(slots=True, kw_only=True)
class Row:
    """Everything measured for one family and size.

    `best`: the exact model's (makespan, bound) by seed, where there is one.
    """

    family: str
    samples: int
    by_engine: dict[str, list[Measure]] = field(default_factory=dict)
    best: dict[int, tuple[float | None, float]] = field(default_factory=dict)

    @property
    def ours(self) -> list[Measure]:
        return [measure for measure in self.by_engine.get(OURS, []) if measure.is_solved]

    def of(self, name: str) -> float | None:
        """The median of one of our figures."""
        return _median(getattr(measure, name) for measure in self.ours)

    @property
    def over_bound(self) -> float | None:
        """By what share our makespans are over their bounds."""
        pairs = [(m.makespan_s, m.bound_s) for m in self.ours]
        return _median(made / bound - 1 for made, bound in pairs if made and bound)

    @property
    def over_model(self) -> float | None:
        """By what share our makespans are over the exact model's optimum, where it proved it; it can be beaten."""
        shares = []
        for measure in self.ours:
            made, bound = self.best.get(measure.task.seed, (None, 0.0))
            if made is not None and measure.makespan_s and made - bound < 0.001:
                shares.append(measure.makespan_s / made - 1)
        return _median(shares)

    def against(self, engine: str) -> str:
        """Solved of asked, median time, and its makespan as a multiple of ours."""
        asked = self.by_engine.get(engine, [])
        if not asked:
            return ""
        solved = [measure for measure in asked if measure.is_solved]
        ours = {measure.task.seed: measure.makespan_s for measure in self.ours}
        pairs = [(m.makespan_s, ours.get(m.task.seed)) for m in solved]
        ratio = _median(theirs / mine for theirs, mine in pairs if theirs and mine)
        time_s = _median(measure.first_s for measure in solved)
        said = [f"{len(solved)}/{len(asked)}"]
        said += [f"{time_s:.1f}s"] if time_s is not None else []
        return " ".join(said + ([f"{ratio:.2f}×"] if ratio is not None else []))


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return median(known) if known else None


def growth(rows: Sequence[Row], family: str) -> float | None:
    """The exponent of the first plan's time over the number of samples, least squares on logarithms."""
    points = [
        (log(row.samples), log(time_s))
        for row in rows
        if row.family == family and GROWTH_FROM <= row.samples <= GROWTH_TO and (time_s := row.of("first_s"))
    ]
    if len(points) < 2:
        return None
    return linear_regression(*zip(*points, strict=True)).slope


HEAD = (
    "family",
    "N",
    "rob",
    "solved",
    "first s",
    "its span",
    "final s",
    "span",
    "bound",
    "over",
    "model",
    "act",
    "MiB",
)


def lines(rows: Sequence[Row], rivals: Sequence[str]) -> list[str]:
    """The table, a line each; a legend above."""
    cells = [[*HEAD, *rivals], *([*_own(row), *(row.against(name) for name in rivals)] for row in rows)]
    widths = [max(len(line[column]) for line in cells) for column in range(len(cells[0]))]
    legend = (
        "Seconds, medians over seeds. span: makespan; bound: proven; over: makespan over bound; model: over the",
        "optimum of the exact model, which leaves out some moves (benchmarks/planner/optimum.py): it can be beaten.",
        "Other engines: solved of asked, time to their first plan-net, their makespan over ours.",
    )
    table = ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in cells]
    return [*legend, "", *table]


def _own(row: Row) -> list[str]:
    asked = row.by_engine.get(OURS, [])
    numbers = {name: row.of(name) for name in ("first_s", "first_makespan_s", "final_s", "makespan_s")}
    return [
        row.family,
        str(row.samples),
        str(max((measure.robots for measure in asked), default="")),
        f"{len(row.ours)}/{len(asked)}",
        *(_number(value, 3 if name == "first_s" else 1) for name, value in numbers.items()),
        _number(row.of("bound_s"), 1),
        _percent(row.over_bound),
        _percent(row.over_model),
        _number(row.of("actions"), 0),
        _number(row.of("memory_mib"), 0),
    ]


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.1f} %"


def faults(by_engine: Mapping[str, Iterable[Measure]]) -> list[str]:
    """The invalid plan-nets of all engines, and what ours did not solve."""
    found = []
    for name, measures in by_engine.items():
        for one in measures:
            where = f"{one.task.family} {one.task.samples} seed {one.task.seed}, {name}"
            if one.fault:
                found.append(f"INVALID: {where}: {one.fault}")
            elif not one.is_solved and name == OURS:
                found.append(f"not solved: {where}: {one.status} {one.reason}")
    return found
