"""Lists of goals and missions are serialised without their models, and say what the models would say."""

from typing import Any

import pytest

from app.api.bodies import GoalBody, goal_document
from app.api.mission_bodies import MissionBody, mission_document
from app.api.plan_json import json_of
from app.store import Database, GoalRow, MissionRow, PlanRow, ScriptRow, WorldRow
from app.store.records import all_of, page, read_only
from tests.databases import ON_BOTH

PLANNING = {"engine": "macta", "elapsed_s": 1.5, "makespan_s": 40.25}  # as recorded before `waits_for`
SEARCH = {"state": "seeking", "count": 4}
TROUBLE = {
    "robot": "yard_1",
    "category": "robot",
    "detail": "the jaws are empty",
    "tag": "DOCK",
    "fit": True,
}
ATTEMPT = {
    "number": 1,
    "at_s": 12.0,
    "failure": "robot",
    "reason": "yard_1 failed",
    "troubles": [TROUBLE],
    "measure": "retry",
    "without": [],
    "plan_id": None,
    "outcome": "approved",
    "detail": "",
}


@pytest.fixture
def rows(database: Database) -> Database:
    """Two goals and two missions, of which one of each has every optional part."""
    with database.write() as session:
        session.add(WorldRow(id="w", title="W", layout={}))
        session.flush()
        session.add_all([goal("plain"), goal("full", planning=PLANNING, alternatives=SEARCH, deadline_s=5.0)])
        session.flush()
        session.add_all([plan("first", "full"), plan("second", "full"), plan("only", "plain")])
        session.flush()
        session.add_all(
            [
                mission("m1", "plain", "only"),
                mission("m2", "full", "second", attempts=[ATTEMPT], tries_left=3),
            ]
        )
        session.flush()
        session.add_all(
            [
                script("s1", "m1", "only", "yard_1"),
                script("s2", "m2", "first", "yard_1", state="failed", abandoned=True),
                script(
                    "s3", "m2", "second", "yard_2", packets={"a": {"state": "running", "started_at_s": 2.0}}
                ),
                script("s4", "m2", "second", "store_1", cleared=["a"]),
            ]
        )
    return database


def goal(name: str, **changes: Any) -> GoalRow:
    known = {
        "text": "move “it” to bay_7",
        "goal": [{"predicate": "in", "args": ["sample_1", "bay_7"]}],
        "priority": 1,
        "auto_approve": False,
        "state": "planning",
        "created_by": "ann",
    }
    return GoalRow(id=name, world="w", **(known | changes))


def plan(name: str, goal_id: str) -> PlanRow:
    return PlanRow(
        id=name, world="w", goal_id=goal_id, state="approved", body={}, world_version=1, duration_factors={}
    )


def mission(name: str, goal_id: str, plan_id: str, **changes: Any) -> MissionRow:
    known: dict[str, Any] = {
        "world": "w",
        "state": "running",
        "workflow": name,
        "estimate_s": 40.0,
        "original_estimate_s": 40.0,
        "margin_s": 30.5,
    }
    return MissionRow(id=name, goal_id=goal_id, plan_id=plan_id, **(known | changes))


def script(name: str, mission_id: str, plan_id: str, robot: str, **changes: Any) -> ScriptRow:
    planned = {"tag": "DOCK", "expected_start_s": 0.0, "expected_duration_s": 2.5, "arguments": {}}
    packets = [planned | {"id": "a", "description": "dock"}, planned | {"id": "b", "after": ["a", "c"]}]
    known = {"delivery": "acknowledged", "body": {"packets": packets}, "packets": {}, "perceived": []}
    return ScriptRow(id=name, mission_id=mission_id, plan_id=plan_id, robot=robot, **(known | changes))


@ON_BOTH
def test_goals_read_as_their_model_says(rows: Database) -> None:
    with rows.read() as session:
        found, _ = page(session, GoalRow, limit=10, after=None)
        objects = {one.id: one for one in session.query(GoalRow)}
    assert len(found) == 2
    for row in found:
        assert json_of(goal_document(row)) == GoalBody.of(objects[row.id]).model_dump_json().encode()


@ON_BOTH
def test_missions_read_as_their_model_says(rows: Database) -> None:
    with rows.read() as session:
        found, _ = page(session, MissionRow, limit=10, after=None)
        scripts = all_of(session, read_only(ScriptRow).order_by(ScriptRow.robot))
    assert len(found) == 2
    for row in found:
        of_it = [one for one in scripts if one.mission_id == row.id]
        expected = MissionBody.of(row, list(of_it))
        assert json_of(mission_document(row, of_it)) == expected.model_dump_json().encode()
    assert {packet.id for packet in expected.progress[0].packets} == {"a", "b"}
