"""How far a mission's plan is by its robots' reports."""

from types import SimpleNamespace
from typing import Any, cast

from app.missions.mission_progress import begun, done, progress_of
from app.store import MissionRow, ScriptRow
from planner import PlanNet

NOW_S = 100.0
NET = cast(
    PlanNet,
    SimpleNamespace(
        actions=[
            SimpleNamespace(id=name, duration_s=span_s)
            for name, span_s in {"come": 10.0, "carry": 30.0, "release": 5.0, "leave": 8.0}.items()
        ]
    ),
)


def script(robot: str, packets: list[str], **known: dict[str, Any]) -> ScriptRow:
    return ScriptRow(robot=robot, body={"packets": [{"id": one} for one in packets]}, packets=known)


def running(since_s: float) -> dict[str, Any]:
    return {"state": "running", "started_at_s": since_s}


FINISHED = {"state": "finished", "started_at_s": 60.0}
SCRIPTS = [
    script("fred", ["come", "carry", "leave"], come=FINISHED, carry=running(80.0)),
    script("ginger", ["carry", "release"], carry=running(85.0), release={"state": "initializing"}),
]


def of(scripts: list[ScriptRow], *, runs_on: bool) -> dict[str, Any]:
    mission = MissionRow(started_at_s=40.0, revised_at_s=None)
    found = progress_of(mission, scripts, NET, without=frozenset({"pebbles"}), now_s=NOW_S, runs_on=runs_on)
    return {
        "done": set(found.done),
        "under_way": dict(found.under_way),
        "lost": set(found.lost),
        "elapsed_s": found.elapsed_s,
    }


def test_what_all_robots_of_an_action_have_ended_is_done() -> None:
    assert done(SCRIPTS) == {"come"}
    assert begun(SCRIPTS) == {"come", "carry"}


def test_once_robots_have_stopped_nothing_is_under_way() -> None:
    assert of(SCRIPTS, runs_on=False) == {
        "done": {"come"},
        "under_way": {},
        "lost": {"pebbles"},
        "elapsed_s": 60.0,
    }


def test_what_runs_on_has_the_rest_of_its_time_left_since_its_first_robot_began() -> None:
    assert of(SCRIPTS, runs_on=True)["under_way"] == {"carry": 10.0}


def test_what_takes_longer_than_planned_has_no_time_left() -> None:
    late = [script("fred", ["come"], come=running(50.0)), script("ginger", ["release"])]
    assert of(late, runs_on=True)["under_way"] == {"come": 0.0}


def test_what_one_robot_has_ended_runs_on_while_the_other_has_not() -> None:
    half = [
        script("fred", ["carry"], carry={"state": "finished", "started_at_s": 80.0}),
        script("ginger", ["carry"], carry=running(80.0)),
    ]
    assert of(half, runs_on=True)["under_way"] == {"carry": 10.0}
