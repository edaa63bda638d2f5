"""Table 1 of P-SMPA over many seeds: how many obstacles are detected, and how long the run takes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean, pstdev

from robots.physical.profile import Architecture
from sim.trials.interference.interferer import Kind
from sim.trials.interference.trial import Trial, run_trial
from sim.trials.parallel import run_parallel

CONDITIONS = tuple((Kind.BOX, times) for times in (6, 7, 8)) + tuple(
    (Kind.BALL, times) for times in (4, 5, 6)
)
"""The table's rows: the obstacle by the sensor that must detect it, and how often one is put in the way."""

Job = tuple[Kind, int, Architecture, int]


@dataclass(frozen=True, slots=True)
class Figure:
    """A mean and a standard deviation over seeds."""

    mean: float
    spread: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Figure":
        return cls(fmean(values), pstdev(values))


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One architecture under one condition. `performance` is the share of interferences detected, 0 to 1."""

    detected: Figure
    performance: Figure
    time_s: Figure
    sensing_j: Figure
    saved_j: Figure
    arrived: int
    trials: int

    @classmethod
    def of(cls, trials: Sequence[Trial], times: int) -> "Cell":
        return cls(
            detected=Figure.of([trial.detected for trial in trials]),
            performance=Figure.of([trial.detected / times for trial in trials]),
            time_s=Figure.of([trial.time_s for trial in trials]),
            sensing_j=Figure.of([trial.sensing_j for trial in trials]),
            saved_j=Figure.of([trial.saved_j for trial in trials]),
            arrived=sum(trial.arrived for trial in trials),
            trials=len(trials),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One condition under both architectures."""

    kind: Kind
    interferences: int
    parallel: Cell
    sequential: Cell


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The rows, and every trial they summarise."""

    rows: Sequence[Row]
    trials: Mapping[Job, Trial]


def run_table(
    seeds: int,
    *,
    workers: int,
    conditions: Sequence[tuple[Kind, int]] = CONDITIONS,
    on_progress: Callable[[int, int], None] = lambda done, of: None,
) -> Table:
    """A row a condition, each cell over the seeds 0 to `seeds` - 1; the figures do not depend on `workers`.

    :param on_progress: called after each trial with the numbers of trials done and in total.
    """
    jobs: list[Job] = [
        (kind, times, architecture, seed)
        for kind, times in conditions
        for architecture in Architecture
        for seed in range(seeds)
    ]
    trials: dict[Job, Trial] = {}
    for job, trial in zip(jobs, run_parallel(_run_job, jobs, workers=workers), strict=True):
        trials[job] = trial
        on_progress(len(trials), len(jobs))

    def cell(kind: Kind, times: int, architecture: Architecture) -> Cell:
        return Cell.of([trials[kind, times, architecture, seed] for seed in range(seeds)], times)

    rows = [
        Row(
            kind=kind,
            interferences=times,
            parallel=cell(kind, times, Architecture.PARALLEL),
            sequential=cell(kind, times, Architecture.SEQUENTIAL),
        )
        for kind, times in conditions
    ]
    return Table(rows=rows, trials=trials)


def _run_job(job: Job) -> Trial:
    return run_trial(*job)
