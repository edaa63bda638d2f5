"""The table of sizes: what its rows say of measures, and that the command plans."""

import pytest

from benchmarks.planner.measure import Measure, Task
from benchmarks.planner.sizes import HEAD, line, main


def measure(seed: int, makespan_s: float | None, *, fault: str | None = None) -> Measure:
    task = Task(engine="macta", family="mixed", samples=4, seed=seed, limit_s=60.0)
    return Measure(
        task=task,
        first_s=0.1 * seed,
        final_s=2.0 * seed,
        cpu_s=float(seed),
        makespan_s=makespan_s,
        bound_s=100.0,
        fault=fault,
    )


def test_a_row_tells_medians_and_worst_cases_and_counts_wrong_plans_as_unsolved() -> None:
    measures = [measure(1, 100.0), measure(2, 130.0), measure(3, 150.0), measure(4, None)]
    cells = line("mixed, 4", [*measures, measure(5, 110.0, fault="a1 needs something")])
    assert HEAD[:6] == (
        "instances",
        "solved",
        "over bound: median",
        "worst",
        "over best known: median",
        "worst",
    )
    assert cells[:6] == ["mixed, 4", "3/5", "30.0 %", "50.0 %", "–", "–"]
    assert cells[6:] == ["0.20", "0.30", "3.0", "5.0", "6.0", "10.0"]


def test_plans_are_compared_with_those_of_a_long_search_and_with_their_bound() -> None:
    measures = [measure(1, 100.5), measure(2, 130.0), measure(3, 150.0), measure(4, None), measure(5, 120.0)]
    searched = [measure(2, 104.0), measure(3, 160.0), measure(4, 110.0), measure(5, 90.0, fault="wrong")]
    assert line("mixed, 4", measures, searched)[4:6] == ["0.0 %", "25.0 %"]  # of seeds 1, 2 and 3


def test_a_row_without_plans_has_no_figures_of_plans() -> None:
    assert line("mixed, 4", [measure(1, None)])[1:6] == ["0/1", "–", "–", "–", "–"]


def test_the_command_prints_the_rows_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--families", "random", "--sizes", "1", "--seeds", "1", "--effort", "0"]) == 0
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith("| random worlds, goals: 1 | 1/1 |")
