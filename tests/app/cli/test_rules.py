"""`macta rules`."""

from pathlib import Path

import pytest

from app.cli.main import app

DEFENDER = Path(__file__).parents[2] / "robots" / "deliberative" / "defender.rules"


def test_a_valid_file_is_summed_up_with_its_version_and_sensors(capsys: pytest.CaptureFixture[str]) -> None:
    app(["rules", "check", str(DEFENDER)], standalone_mode=False)
    said = capsys.readouterr().out
    assert said.startswith("defender ")
    assert "valid; 5 rules, 0 plans, 1 perceptor; needs bumper, gripper, infra_red, ultrasonic" in said


def test_a_fault_is_reported_with_file_line_and_column(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bad.rules"
    file.write_text("AGENT bad;\nBELIEF(startup) => COMMIT(activate(MOVE_TOO()));\n")
    with pytest.raises(SystemExit, match="2"):
        app(["rules", "check", str(file)])
    assert f"{file}:2:27: unknown packet MOVE_TOO; did you mean MOVE_TO?" in capsys.readouterr().err


def test_shipped_files_are_listed_shown_and_checked_by_name(capsys: pytest.CaptureFixture[str]) -> None:
    app(["rules", "list"], standalone_mode=False)
    listed = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert listed["charging"] == "A robot with a low battery and no script drives home and is charged"
    app(["rules", "show", "charging"], standalone_mode=False)
    assert capsys.readouterr().out.startswith("AGENT charging;\n")
    together = [["soccer_player", "attacker", "left_defender"], ["soccer_player", "opponent"]]
    for names in [[one] for one in listed if one not in {*together[0], *together[1]}] + together:
        app(["rules", "check", *names], standalone_mode=False)
        said = capsys.readouterr().out
        assert all(f"{name} " in said for name in names)
    with pytest.raises(SystemExit, match="2"):
        app(["rules", "show", "parking"])
    assert "no rule file parking; those that ship: attacker, charging, " in capsys.readouterr().err
