"""Figures like P-SMPA's 5 and 6, as SVG: readings of sonar and bumper on one run to the door."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from robots.physical.profile import Architecture
from sim.trials.interference.corridor import SONAR_MAX_M
from sim.trials.interference.interferer import THRESHOLD_M, Kind
from sim.trials.interference.table import Job
from sim.trials.interference.trial import Trial

WIDTH = 860
PANEL = 190
LEFT = 60
RIGHT = 20
TOP = 40
GAP = 70
SHOWN = {Kind.BOX: 8, Kind.BALL: 4}
"""The numbers of interferences in figs 5 and 6."""
TITLES = {
    Kind.BOX: "Sonar detection; green: seen before it is run into, red: not",
    Kind.BALL: "Bumper detection; green: felt, red: not",
}
PANELS = {Architecture.PARALLEL: "(a) parallel", Architecture.SEQUENTIAL: "(b) sequential"}
AXES = {
    Kind.BOX: ("distance, m; 0: off", SONAR_MAX_M, (0.0, THRESHOLD_M, 1.0, 1.5, 2.0, 2.5)),
    Kind.BALL: ("0 off, 1 free, 2 touched", 2.2, (0.0, 1.0, 2.0)),
}


def write_plots(folder: Path, trials: Mapping[Job, Trial]) -> list[Path]:
    """One figure a sensor, of the first seed's runs.

    :raises OSError: if the folder cannot be written to.
    """
    written = []
    for number, kind in enumerate((Kind.BOX, Kind.BALL), start=5):
        runs = {each: trials[kind, SHOWN[kind], each, 0] for each in Architecture}
        path = folder / f"figure_{number}_{kind}.svg"
        path.write_text(figure(kind, runs), encoding="utf-8")
        written.append(path)
    return written


def figure(kind: Kind, trials: dict[Architecture, Trial]) -> str:
    """Both architectures below each other, on one time scale; a band per interference, green if it was detected."""
    end_s = max(trial.time_s for trial in trials.values())
    height = TOP + len(trials) * (PANEL + GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
        f'height="{height}" font-family="sans-serif" font-size="12" fill="#222">',
        f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
        f'<text x="{WIDTH / 2}" y="20" text-anchor="middle" font-size="15">{TITLES[kind]}</text>',
    ]
    for number, (architecture, trial) in enumerate(trials.items()):
        parts += _panel(kind, PANELS[architecture], trial, TOP + number * (PANEL + GAP), end_s)
    return "\n".join([*parts, "</svg>", ""])


def _panel(kind: Kind, title: str, trial: Trial, top: float, end_s: float) -> list[str]:
    label, highest, marks = AXES[kind]
    right = WIDTH - RIGHT
    foot = top + PANEL

    def x(time_s: float) -> float:
        return LEFT + (right - LEFT) * time_s / end_s

    def y(value: float) -> float:
        return foot - PANEL * value / highest

    caption = f"{title}: {trial.detected} of {len(trial.interferences)} noticed, {trial.time_s:.0f} s"
    parts = [f'<text x="{LEFT}" y="{top - 6}">{caption}</text>']
    for one in trial.interferences:
        until_s = one.until_s or trial.time_s
        colour = "#9fd3a8" if one.detected else "#f0b3ab"
        parts.append(
            f'<rect x="{x(one.since_s):.1f}" y="{top}" width="{x(until_s) - x(one.since_s):.1f}" '
            f'height="{PANEL}" fill="{colour}" fill-opacity="0.6"/>'
        )
    for mark in marks:
        dash = ' stroke-dasharray="5 4"' if mark == THRESHOLD_M else ""
        parts.append(
            f'<line x1="{LEFT}" y1="{y(mark):.1f}" x2="{right}" y2="{y(mark):.1f}" stroke="#bbb"{dash}/>'
            f'<text x="{LEFT - 6}" y="{y(mark) + 4:.1f}" text-anchor="end">{mark:g}</text>'
        )
    for mark_s in range(0, int(end_s) + 1, 10):
        parts.append(f'<text x="{x(mark_s):.1f}" y="{foot + 16}" text-anchor="middle">{mark_s}</text>')
    parts.append(f'<text x="{right}" y="{foot + 32}" text-anchor="end">time, s</text>')
    middle = top + PANEL / 2
    parts.append(
        f'<text x="14" y="{middle}" text-anchor="middle" transform="rotate(-90 14 {middle})">{label}</text>'
    )
    values = [instant.sonar_m if kind is Kind.BOX else instant.bumper for instant in trial.trace]
    times = [x(instant.time_s) for instant in trial.trace]
    points = " ".join(_steps([(at, y(value)) for at, value in zip(times, values, strict=True)]))
    parts.append(f'<polyline points="{points}" fill="none" stroke="#1f5fa8" stroke-width="1.4"/>')
    return parts


def _steps(points: Sequence[tuple[float, float]]) -> list[str]:
    """A step line, without the points along a straight step."""
    kept: list[tuple[float, float]] = []
    for here, (x, y) in enumerate(points):
        if kept and kept[-1][1] == y and 0 < here < len(points) - 1:
            continue
        if kept:
            kept.append((x, kept[-1][1]))
        kept.append((x, y))
    return [f"{x:.1f},{y:.1f}" for x, y in kept]
