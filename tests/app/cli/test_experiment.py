"""`macta experiment interference` prints table 1, or its rows as JSON and nothing else."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import app.cli.experiment
from app.cli.main import app as macta
from robots.physical.profile import Architecture
from sim.trials.interference.interferer import Interference, Kind
from sim.trials.interference.table import Cell, Figure, Row, Table
from sim.trials.interference.trial import Instant, Trial

EXACT = Figure(0.0, 0.0)


def cell(detected: float, of: int, time_s: float) -> Cell:
    return Cell(
        detected=Figure(detected, 0.5),
        performance=Figure(detected / of, 0.1),
        time_s=Figure(time_s, 2.0),
        sensing_j=EXACT,
        saved_j=EXACT,
        arrived=3,
        trials=3,
    )


WAY = Trial(
    arrived=True,
    time_s=30.0,
    interferences=(Interference(since_s=5.0),),
    trace=(Instant(time_s=0.0, sonar_m=0.0, bumper=0), Instant(time_s=30.0, sonar_m=2.5, bumper=1)),
    sensing_j=1.0,
    saved_j=1.0,
)
SHOWN = [(Kind.BOX, 8), (Kind.BALL, 4)]


@pytest.fixture(autouse=True)
def rows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No trials are run; the figures are of one that was not."""

    def table(seeds: int, **_: object) -> Table:
        assert seeds == 3
        rows = [
            Row(kind=Kind.BOX, interferences=6, parallel=cell(6, 6, 30), sequential=cell(3, 6, 75)),
            Row(kind=Kind.BALL, interferences=4, parallel=cell(4, 4, 25), sequential=cell(2, 4, 60)),
        ]
        return Table(rows=rows, trials={(*shown, each, 0): WAY for shown in SHOWN for each in Architecture})

    monkeypatch.setattr(app.cli.experiment, "run_table", table)
    monkeypatch.chdir(tmp_path)


def test_json_is_one_document_of_rows() -> None:
    result = CliRunner().invoke(macta, ["experiment", "interference", "--seeds", "3", "--json"])
    assert result.exit_code == 0
    body = json.loads(result.stdout)
    assert body["rows"][0] == {
        "sensor": "sonar",
        "interferences": 6,
        "parallel": {"detected": 6, "performance": 1.0, "time_s": 30},
        "sequential": {"detected": 3, "performance": 0.5, "time_s": 75},
    }
    assert [(row["sensor"], row["interferences"]) for row in body["rows"]] == [("sonar", 6), ("bumper", 4)]
    assert list(body) == ["rows"]


def test_the_table_tells_what_was_detected_and_how_long_it_took(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    result = CliRunner().invoke(macta, ["experiment", "interference", "--seeds", "3"])
    assert result.exit_code == 0
    assert "sonar" in result.stdout
    assert "sequential" in result.stdout
    assert "…" not in result.stdout
    assert "12 of 12 trials ended at the door." in result.stdout
    assert "at most 0.42 of the time of sequential sensing" in result.stdout


@pytest.mark.parametrize("given", [(), ("--plots", "pictures/new")])
def test_the_figures_are_written_and_named(tmp_path: Path, given: tuple[str, ...]) -> None:
    result = CliRunner().invoke(macta, ["experiment", "interference", "--seeds", "3", *given])
    folder = tmp_path / (given[-1] if given else "macta-figures")
    assert sorted(path.name for path in folder.iterdir()) == ["figure_5_sonar.svg", "figure_6_bumper.svg"]
    assert "figure_5_sonar.svg" in "".join(result.stderr.split())


def test_figures_that_cannot_be_written_are_refused_before_anything_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(*_: object, **__: object) -> Table:
        raise AssertionError("it was run")

    monkeypatch.setattr(app.cli.experiment, "run_table", run)
    (tmp_path / "taken").touch()
    result = CliRunner().invoke(macta, ["experiment", "interference", "--plots", "taken/plots"])
    assert result.exit_code == 2
    assert "--plots" in result.stderr
