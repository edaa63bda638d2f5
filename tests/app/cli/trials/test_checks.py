"""What a soak judges: each way in which record and world may disagree is found, and agreement is not complained of."""

from typing import Any

from app.cli.trials.checks import (
    Beliefs,
    RecordedReports,
    disagreements,
    executed_twice,
    lost_events,
    unfinished_goals,
    untrue_goals,
)
from app.store import Database, MessageRow, ScriptRow

DONE = {"state": "finished", "outcome": "completed", "reason": "", "text": "move sample_1 to bay_7"}
GOAL: dict[str, Any] = {"id": "goal-1", "goal": [{"predicate": "in", "args": ["sample_1", "bay_7"]}], **DONE}


def packet(script: str, state: str, at_s: float) -> dict[str, Any]:
    body = {"kind": "packet_report", "script_id": script, "packet_id": "a1", "state": state, "at_s": at_s}
    return {**body, "detail": "", "events": []}


def record(*told: dict[str, Any], **robots: str) -> RecordedReports:
    """:param robots: the robot of each script."""
    scripts = [ScriptRow(id=script, robot=robot) for script, robot in robots.items()]
    return RecordedReports(reports=told, scripts=scripts, events=[])


def test_a_goal_that_is_over_and_says_how_is_no_matter_of_complaint() -> None:
    assert unfinished_goals([GOAL]) == []
    assert unfinished_goals([{**GOAL, "state": "committed", "outcome": None}]) == [
        "goal-1 did not end: committed, "
    ]
    assert unfinished_goals([{**GOAL, "outcome": None}]) == ["goal-1 is finished without an outcome"]


def test_only_what_was_said_to_be_completed_must_be_true() -> None:
    assert untrue_goals([GOAL], lambda _: True) == []
    assert untrue_goals([{**GOAL, "outcome": "failed"}], lambda _: False) == []
    (words,) = untrue_goals([GOAL], lambda _: False)
    assert words == "goal-1 (move sample_1 to bay_7) was completed, but in(sample_1, bay_7) is not true"


def test_a_sample_is_believed_where_it_is_or_known_to_be_unknown() -> None:
    here = Beliefs(facts=[("in", ("sample_1", "bay_7"))])
    assert disagreements(here, {"sample_1": "bay_7"}, {}) == []
    assert disagreements(here, {"sample_1": "bay_7_2"}, {"bay_7_2": "bay_7"}) == []
    assert disagreements(Beliefs(facts=[], unknown=["sample_1"]), {"sample_1": None}, {}) == []
    assert disagreements(here, {"sample_1": None}, {}) == [
        "sample_1 is in no place, and believed in ['bay_7']"
    ]
    assert disagreements(Beliefs(facts=[]), {"sample_1": "bay_7"}, {}) == [
        "sample_1 is in bay_7, and believed in no place"
    ]


def test_what_is_begun_or_ended_twice_is_found() -> None:
    once = record(packet("s", "running", 1.0), packet("s", "finished", 2.0), s="fred")
    assert executed_twice(once) == []
    again = record(packet("s", "finished", 2.0), packet("s", "finished", 3.0), s="fred")
    assert executed_twice(again) == ["a1 of s was finished 2 times"]


def test_a_packet_that_goes_on_after_a_pause_does_not_begin_again() -> None:
    told = [
        packet("s", state, at_s) for at_s, state in enumerate(("running", "paused", "running", "finished"))
    ]
    assert executed_twice(record(*told, s="fred")) == []
    begun_again = [*told[:3], packet("s", "running", 2.5), told[3]]
    assert executed_twice(record(*begun_again, s="fred")) == ["a1 of s was running 2 times"]


def test_of_the_recorded_messages_only_starts_pauses_and_ends_count(database: Database) -> None:
    bodies = [
        packet("s", "running", 2.0),
        packet("s", "running", 3.0) | {"detail": "still on its way"},
        packet("s", "running", 4.0) | {"events": ["let_go"]},
        packet("s", "waiting", 1.0),
        packet("s", "finished", 5.0),
        packet("s", "finished", 6.0) | {"kind": "script_report"},
        packet("s", "running", 0.0) | {"kind": "script_report"},
        packet("s", "finished", 7.0) | {"kind": "upkeep_report"},
    ]
    with database.write() as session:
        for number, body in enumerate(bodies):
            session.add(MessageRow(id=f"m{number}", robot="fred", kind=body["kind"], body={"body": body}))
    read = RecordedReports.read(database.url)
    assert [body["at_s"] for body in read.reports] == [2.0, 5.0, 6.0]
    assert read.executed() == {
        ("s", "a1", "running"): 1,
        ("s", "a1", "finished"): 1,
        ("s", "the script", "finished"): 1,
    }


def test_two_scripts_of_one_robot_that_overlap_are_found() -> None:
    spans = [packet("s", "running", 1.0), packet("t", "running", 2.0), packet("s", "finished", 3.0)]
    assert executed_twice(record(*spans, s="fred", t="fred")) == ["s and t ran on one robot at once"]
    assert executed_twice(record(*spans, s="fred", t="ginger")) == []


def test_a_stream_tells_every_event_once_and_in_order() -> None:
    assert lost_events([1, 2, 3], [1, 2, 3]) == []
    assert lost_events([1, 3], [1, 2, 3]) == ["the event stream had 2 of 3: not [2], 0 twice, in order"]
    assert "1 twice" in lost_events([1, 2, 2, 3], [1, 2, 3])[0]
    assert "out of order" in lost_events([2, 1, 3], [1, 2, 3])[0]
