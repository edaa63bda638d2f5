"""`macta rules try`: rule files on the recording of a mission."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from app.cli.main import app
from app.domain.world_model.layout import layout_of
from app.recordings.mcap_writer import EVENTS, MINDS, SCRIPT, WORLD, McapWriter
from robots.wire import MindReport, Telemetry, ToldMessage
from robots.world import load_world

SENSORS = ("gripper", "infra_red", "ultrasonic")
SCRIPT_BODY = {"id": "script-1", "robot": "yard_1", "packets": [{"id": "a1", "tag": "NAVIGATE"}]}


def told(at_s: float, **fields: Any) -> Telemetry:
    said = {
        "at_s": at_s,
        "x_m": 2.0,
        "y_m": 1.5,
        "heading_rad": 0.0,
        "sensors": SENSORS,
        "ranges_m": [None] * 16,
    }
    return Telemetry.model_validate(said | fields)


def record(
    file: Path,
    *telemetry: Telemetry,
    events: Mapping[float, list[str]] | None = None,
    heard: Mapping[float, str] | None = None,
) -> Path:
    """A recording of yard_1's telemetry, of the events that its packet raised, and of what yard_2 has asked of it.

    :param heard: the contents by time; None: its mind does not tell of messages.
    """
    with McapWriter(file) as writer:
        writer.write_json(WORLD, {"id": "store", "layout": layout_of(load_world("sample_store"))}, 0.0)
        writer.write_json(SCRIPT, SCRIPT_BODY, 0.0)
        for one in telemetry:
            writer.write_robots({"yard_1": one, "yard_2": one}, whole={"yard_1"})
        for at_s, raised in (events or {}).items():
            data = {"robot": "yard_1", "packet": "a1", "at_s": at_s, "events": raised}
            writer.write_json(EVENTS, {"type": "packet.running", "subject": "mission-1", "data": data}, at_s)
        messages = [
            ToldMessage(at_s=at_s, performative="request", sender="yard_2", content=content)
            for at_s, content in (heard or {}).items()
        ]
        for count in range(len(messages) + 1) if heard is not None else ():
            mind = MindReport(at_s=0.0, heard=tuple(messages[:count]))
            writer.write_json(f"{MINDS}yard_1", mind.model_dump(mode="json"), float(count))
    return file


def tried(capsys: pytest.CaptureFixture[str], file: Path, *rules: str) -> tuple[list[str], str]:
    """The lines printed, their spaces single, and what was said on standard error."""
    app(["rules", "try", *rules, "--recording", str(file), "--robot", "yard_1"], standalone_mode=False)
    said = capsys.readouterr()
    return [" ".join(line.split()) for line in said.out.splitlines()], said.err


def test_rules_fire_by_what_the_robot_perceived_then(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    batteries = [told(at_s / 2, battery=1.0 if at_s < 10 else 0.2) for at_s in range(20)]
    lines, errors = tried(capsys, record(tmp_path / "one.mcap", *batteries), "charging")
    assert lines[0].startswith("5.0 s charging charging:")
    assert lines[0].endswith("recharge ?place = home_yard_1")
    assert lines[-1] == "2 firings from 0.0 to 9.5 s, in 20 records of yard_1"
    assert errors == ""


def test_a_script_of_the_service_and_events_of_its_packets_are_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    under_way = {
        "script_id": "script-1",
        "script_state": "running",
        "packet_id": "a1",
        "packet_tag": "NAVIGATE",
    }
    telemetry = [told(at_s / 2, **under_way, packet_state="running", battery=0.2) for at_s in range(60)]
    file = record(tmp_path / "one.mcap", *telemetry, events={8.2: ["stuck"], 20.0: ["stuck"]})
    lines, _ = tried(capsys, file, "unstuck", "charging")
    assert lines == [
        "8.5 s unstuck unstuck:8 back_off ?tag = NAVIGATE",
        "20.0 s unstuck unstuck:11 back_off ?tag = NAVIGATE",
        "2 firings from 0.0 to 29.5 s, in 60 records of yard_1",
    ]


def test_a_stall_is_told_to_the_rules_that_act_on_its_cause(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    under_way = {"script_id": "script-1", "script_state": "running", "packet_id": "a1", "packet_tag": "DOCK"}
    telemetry = [told(at_s / 2, **under_way, packet_state="running") for at_s in range(40)]
    file = record(tmp_path / "one.mcap", *telemetry, events={8.2: ["stuck", "missed"]})
    lines, _ = tried(capsys, file, "unstuck", "regrip")
    assert [line.split()[2:4] for line in lines[:-1]] == [["regrip", "regrip:7"]]
    lines, _ = tried(capsys, file, "unstuck")
    assert [line.split()[2:4] for line in lines[:-1]] == [["unstuck", "unstuck:8"]]


def test_things_in_view_are_perceived_and_what_is_not_recorded_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules = tmp_path / "guard.rules"
    rules.write_text(
        "AGENT guard;\n"
        "PERCEPTOR near(?x) IS close(object: ?x, m: 1.0) FOR ?x IN tracked;\n"
        "PERCEPTOR free IS vacant(place: door_1);\n"
        "BELIEF(near(?x)) => COMMIT(adoptBelief(met(?x)));\n"
        "BELIEF(not(free)) => COMMIT(adoptBelief(taken));\n"
    )
    away, close = {"sample_1": (4.5, 1.5)}, {"sample_1": (2.6, 1.5)}
    telemetry = [told(at_s / 10, tags=away if at_s < 30 else close) for at_s in range(80)]
    lines, errors = tried(capsys, record(tmp_path / "one.mcap", *telemetry), str(rules))
    (fired, _) = lines
    assert fired.endswith("guard guard:4 beliefs only ?x = sample_1")
    assert 3.0 <= float(fired.split()[0]) < 8.0
    assert "guard:3: free is not recorded" in errors


ANSWERS = """AGENT guard;
ACTUATOR say(agree);
BELIEF(message(request, ?who, cover(?what))) => COMMIT(say(agree, ?who, cover(?what)));
"""


def test_rules_hear_what_was_said_to_the_robot_then(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules = tmp_path / "guard.rules"
    rules.write_text(ANSWERS)
    telemetry = [told(at_s / 2) for at_s in range(20)]
    heard = {0.7: "cover(door_1)", 3.2: 'cover("bay 3")', 4.0: "rest", 5.0: "cover(a_very_long…"}
    lines, errors = tried(capsys, record(tmp_path / "one.mcap", *telemetry, heard=heard), str(rules))
    assert lines[:-1] == [
        "1.0 s guard guard:3 say ?who = yard_2, ?what = door_1",
        '3.5 s guard guard:3 say ?who = yard_2, ?what = "bay 3"',
    ]
    assert errors.strip() == "1 message to yard_1 is not recorded whole"
    lines, errors = tried(capsys, record(tmp_path / "two.mcap", *telemetry), str(rules))
    assert lines == ["0 firings from 0.0 to 9.5 s, in 20 records of yard_1"]
    assert errors.strip() == "what was said to yard_1 is not recorded: it had no rules then"


def test_rules_feel_what_the_robot_has_touched_if_its_bumper_ran(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rules = tmp_path / "guard.rules"
    rules.write_text(
        "AGENT guard;\nPERCEPTOR hit IS bumped(within_s: 0.2);\n"
        "BELIEF(hit) => COMMIT(adoptBelief(once));\nBELIEF(not(hit)) => COMMIT(adoptBelief(free));\n"
    )
    touched = [told(at_s / 2, touched=at_s == 6) for at_s in range(20)]
    lines, errors = tried(capsys, record(tmp_path / "one.mcap", *touched), str(rules))
    assert [line.split()[0:4:3] for line in lines[:-1]] == [
        ["0.0", "guard:4"],
        ["3.0", "guard:3"],
        ["3.5", "guard:4"],
    ]
    assert errors == ""
    untold = [told(at_s / 2) for at_s in range(20)]
    lines, errors = tried(capsys, record(tmp_path / "two.mcap", *untold), str(rules))
    assert lines[0].startswith("0 firings")
    assert "guard:2: hit is not recorded" in errors


def test_what_cannot_be_tried_is_said_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def refused(file: Path, robot: str = "yard_1") -> str:
        with pytest.raises(SystemExit, match="2"):
            app(["rules", "try", "charging", "--recording", str(file), "--robot", robot])
        return capsys.readouterr().err

    assert "no recording" in refused(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("no recording at all")
    assert "is no recording of a mission of yard_1" in refused(tmp_path / "text.mcap")
    file = record(tmp_path / "one.mcap", told(0.0))
    said = refused(file, "yard_2")
    assert "is no recording of a mission of yard_2" in said
    assert said.strip().endswith("choices: yard_1")
