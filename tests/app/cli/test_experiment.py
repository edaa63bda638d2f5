"""`macta experiment interference` prints table 1, or its rows as JSON and nothing else."""

import json
from collections.abc import Sequence

import pytest
from typer.testing import CliRunner

import app.cli.experiment
from app.cli.main import app as macta
from sim.interference.interferer import Kind
from sim.interference.table import Cell, Figure, Row

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


@pytest.fixture(autouse=True)
def rows(monkeypatch: pytest.MonkeyPatch) -> None:
    def table(seeds: int, **_: object) -> Sequence[Row]:
        assert seeds == 3
        return [
            Row(kind=Kind.BOX, interferences=6, parallel=cell(6, 6, 30), sequential=cell(3, 6, 75)),
            Row(kind=Kind.BALL, interferences=4, parallel=cell(4, 4, 25), sequential=cell(2, 4, 60)),
        ]

    monkeypatch.setattr(app.cli.experiment, "run_table", table)


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


def test_the_table_tells_what_was_detected_and_how_long_it_took() -> None:
    result = CliRunner().invoke(macta, ["experiment", "interference", "--seeds", "3"])
    assert result.exit_code == 0
    assert "sonar" in result.stdout
    assert "12 of 12 ways ended at the door." in result.stdout
    assert "at most 0.42 of sequential's time" in result.stdout


def test_figures_that_cannot_be_written_are_told_in_a_line(tmp_path: object) -> None:
    file = f"{tmp_path}/taken"
    with open(file, "w"):
        pass
    result = CliRunner().invoke(
        macta, ["experiment", "interference", "--seeds", "3", "--json", "--plots", f"{file}/plots"]
    )
    assert result.exit_code == 2
    assert "--plots" in result.stderr
