"""`macta experiment`: experiments of the papers, run on the simulated robots."""

import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from app.domain.errors import Invalid
from sim.trials.interference.plots import write_plots
from sim.trials.interference.table import Cell, Figure, Row, run_table

Written = TypeVar("Written")


def interference(seeds: int, *, as_json: bool, plots: Path) -> None:
    """P-SMPA's table 1 over many seeds, and its figures 5 and 6.

    :param plots: the folder to write the figures to; created before the trials.
    :raises Invalid: if it cannot be created, or the figures cannot be written.
    """
    _with_folder(plots, lambda: plots.mkdir(parents=True, exist_ok=True))
    progress = Progress(console=Console(stderr=True), transient=True)
    with progress:
        task = progress.add_task("trials")
        table = run_table(
            seeds,
            workers=os.cpu_count() or 1,
            on_progress=lambda done, of: progress.update(task, completed=done, total=of),
        )
    if as_json:
        json.dump({"rows": [_row_body(row) for row in table.rows]}, sys.stdout, indent=2)
        sys.stdout.write("\n")
    else:
        _show(table.rows, seeds)
    written = _with_folder(plots, lambda: write_plots(plots, table.trials))
    Console(stderr=True, highlight=False).print(f"Wrote {', '.join(map(str, written))}.")


def _with_folder(folder: Path, write: Callable[[], Written]) -> Written:
    try:
        return write()
    except OSError as error:
        raise Invalid(f"--plots: {folder} cannot be written: {error.strerror}") from error


def _row_body(row: Row) -> dict[str, object]:
    return {
        "sensor": row.kind.value,
        "interferences": row.interferences,
        "parallel": _cell_body(row.parallel),
        "sequential": _cell_body(row.sequential),
    }


def _cell_body(cell: Cell) -> dict[str, float]:
    figures = {"detected": cell.detected, "performance": cell.performance, "time_s": cell.time_s}
    return {name: figure.mean for name, figure in figures.items()}


def _show(rows: Sequence[Row], seeds: int) -> None:
    title = f"Parallel and sequential sensing, mean ± standard deviation of {seeds} seeds"
    table = Table(title=title, box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    for heading in ("Sensor", "Times", "Sensing", "Detected", "Perf. %", "Time s", "Used J", "Saved J"):
        table.add_column(heading, justify="left" if heading in ("Sensor", "Sensing") else "right")
    for row in rows:
        table.add_row(row.kind.value, str(row.interferences), "parallel", *_cells(row.parallel))
        table.add_row("", "", "sequential", *_cells(row.sequential), end_section=True)
    console = Console(highlight=False)
    console.print(table)
    cells = [cell for row in rows for cell in (row.parallel, row.sequential)]
    arrived = sum(cell.arrived for cell in cells)
    trials = sum(cell.trials for cell in cells)
    worst = max(row.parallel.time_s.mean / row.sequential.time_s.mean for row in rows)
    console.print(
        "Times: obstacles put in the way. J: energy used by sensors, and saved by sensors that are off."
    )
    console.print(f"{arrived} of {trials} trials ended at the door.")
    console.print(f"Parallel sensing takes at most {worst:.2f} of the time of sequential sensing.")


def _cells(cell: Cell) -> list[str]:
    share = Figure(100 * cell.performance.mean, 100 * cell.performance.spread)
    energy = [f"{cell.sensing_j.mean:.0f}", f"{cell.saved_j.mean:.0f}"]
    return [_told(cell.detected, 1), _told(share, 0), _told(cell.time_s, 0), *energy]


def _told(figure: Figure, digits: int) -> str:
    return f"{figure.mean:.{digits}f} ± {figure.spread:.{digits}f}"
