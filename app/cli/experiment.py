"""`macta experiment`: experiments of the papers, run on the simulated robots."""

import json
import os
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from app.errors import Invalid
from sim.interference.plots import write_plots
from sim.interference.table import Cell, Figure, Row, run_table


def interference(seeds: int, *, as_json: bool, plots: Path | None) -> None:
    """P-SMPA's table 1 over many seeds, and its figures 5 and 6.

    :raises Invalid: if the figures cannot be written.
    """
    progress = Progress(console=Console(stderr=True), transient=True)
    with progress:
        task = progress.add_task("trials")
        rows = run_table(
            seeds,
            workers=os.cpu_count() or 1,
            told=lambda done, of: progress.update(task, completed=done, total=of),
        )
    if as_json:
        json.dump({"rows": [_row_body(row) for row in rows]}, sys.stdout)
        sys.stdout.write("\n")
    else:
        _show(rows, seeds)
    if plots is None:
        return
    try:
        written = write_plots(plots)
    except OSError as error:
        raise Invalid(f"--plots: {plots} cannot be written: {error.strerror}") from error
    Console(stderr=True, highlight=False).print(f"Wrote {', '.join(map(str, written))}.")


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


def _show(rows: list[Row], seeds: int) -> None:
    table = Table(title=f"Parallel and sequential sensing, mean ± standard deviation of {seeds} seeds")
    for heading in ("Sensor", "Times", "Sensing", "Detected", "Perf. %", "Time s", "Used J", "Saved J"):
        table.add_column(heading, justify="left" if heading in ("Sensor", "Sensing") else "right")
    for row in rows:
        table.add_row(row.kind.value, str(row.interferences), "parallel", *_cells(row.parallel))
        table.add_row("", "", "sequential", *_cells(row.sequential), end_section=True)
    console = Console(highlight=False)
    console.print(table)
    cells = [cell for row in rows for cell in (row.parallel, row.sequential)]
    arrived, trials = sum(cell.arrived for cell in cells), sum(cell.trials for cell in cells)
    worst = max(row.parallel.time_s.mean / row.sequential.time_s.mean for row in rows)
    console.print(f"{arrived} of {trials} ways ended at the door.")
    console.print(f"Parallel takes at most {worst:.2f} of sequential's time.")


def _cells(cell: Cell) -> list[str]:
    share = Figure(100 * cell.performance.mean, 100 * cell.performance.spread)
    energy = [f"{cell.sensing_j.mean:.0f}", f"{cell.saved_j.mean:.0f}"]
    return [_told(cell.detected, 1), _told(share, 0), _told(cell.time_s, 0), *energy]


def _told(figure: Figure, digits: int) -> str:
    return f"{figure.mean:.{digits}f} ± {figure.spread:.{digits}f}"
