"""Worlds that operators change while missions run: checked, recorded, undone, and gone on with after a restart."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from robots.wire import SampleReport
from robots.world import WorldFile
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
WORLD = "/v1/worlds/sample_store"
CHANGES = f"{WORLD}/changes"
NEW = {"edit": "add_sample", "sample": {"name": "sample_9", "at": "door_2"}}


def gone(name: str) -> dict[str, str]:
    return {"edit": "remove_sample", "name": name}


def change(api: TestClient, *edits: dict[str, Any], **headers: str) -> Any:
    body = {"edits": edits, "reason": "a delivery"}
    return api.post(CHANGES, json=body, headers={name.replace("_", "-"): v for name, v in headers.items()})


def changed(api: TestClient, *edits: dict[str, Any]) -> dict[str, Any]:
    answer = change(api, *edits)
    assert answer.status_code == 200, answer.text
    return answer.json()  # type: ignore[no-any-return]


def facts(api: TestClient) -> dict[str, str]:
    """Each fact with its source."""
    items = api.get(f"{WORLD}/facts").json()["items"]
    return {f"{one['predicate']}({', '.join(one['args'])})": one["source"] for one in items}


def stated(api: TestClient, text: str) -> str:
    return f"/v1/goals/{api.post('/v1/goals', json={'text': text}).raise_for_status().json()['id']}"


@ON_BOTH
def test_a_sample_that_is_added_can_be_moved_at_once(
    api: TestClient, follow: Follow, team: FakeTeam, service: Service
) -> None:
    made = changed(api, NEW)
    assert (made["edition"], made["actor"], made["reason"]) == (1, "administrator", "a delivery")
    known = facts(api)
    assert known["in(sample_9, door_2)"] == "operator administrator"
    assert "vacant(door_2)" not in known
    plan = follow(stated(api, "move sample_9 to bay_7"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    assert follow(f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
    assert "in(sample_9, bay_7)" in facts(api)
    until(lambda: team.editions == [1])
    until(lambda: api.get(CHANGES).json()["items"][0]["delivery"] == "taken_up")
    told = {event.type: event.data for event in service.events.since(0)}
    assert told["world.changed"]["changes"] == ["added sample_9 at door_2"]
    assert told["world.change_taken_up"]["edition"] == 1


def test_a_sample_that_is_removed_is_in_no_fact_and_a_goal_for_it_has_no_plan(
    api: TestClient, follow: Follow
) -> None:
    open_goal = stated(api, "move sample_1 to bay_7")
    plan = follow(open_goal, "planned")["plan_id"]
    edits = [gone("sample_1")]
    check = api.post(f"{CHANGES}:check", json={"edits": edits}).raise_for_status().json()
    assert check["outdated_plans"] == [plan]
    assert {"predicate": "in", "args": ["sample_1", "door_1"]} in check["removed"]
    assert {"predicate": "vacant", "args": ["door_1"]} in check["added"]
    assert "in(sample_1, door_1)" in facts(api)
    changed(api, *edits)
    assert not any("sample_1" in fact for fact in facts(api))
    assert "vacant(door_1)" in facts(api)
    assert api.get(f"{WORLD}/unknown").json()["items"] == []
    refused = api.post(f"/v1/plans/{plan}:approve", json={})
    assert (refused.status_code, "sample_1" in refused.json()["detail"]) == (409, True)
    assert api.get(f"/v1/plans/{plan}").status_code == 200
    ended = follow(open_goal, "unsolvable")
    assert "sample_1" in ended["reason"]


@pytest.mark.parametrize(
    ("edit", "status", "code", "words", "choice"),
    [
        (gone("sample_7"), 404, "unknown-sample", "unknown sample 'sample_7'", "sample_3"),
        ({**NEW, "sample": {"name": "sample_9", "at": "bay_77"}}, 404, "unknown-place", "bay_77", "bay_7"),
        ({**NEW, "sample": {"name": "yard_1", "at": "bay_7"}}, 422, "name-in-use", "name yard_1 is in use", None),
        (
            {**NEW, "sample": {"name": "sample_9", "at": "door_1"}},
            409,
            "place-occupied",
            "sample_1 lies there",
            "door_2",
        ),
        (
            {**NEW, "sample": {"name": "sample_9", "at": "home_yard_1"}},
            409,
            "place-occupied",
            "it is a home, which holds none",
            "door_2",
        ),
    ],
)  # fmt: skip
def test_an_edit_that_cannot_be_made_says_which_why_and_what_can(
    api: TestClient, edit: dict[str, Any], status: int, code: str, words: str, choice: str | None
) -> None:
    refused = change(api, NEW | {"sample": {"name": "sample_8", "at": "bay_1"}}, edit)
    told = refused.json()
    assert (refused.status_code, told["type"]) == (status, f"urn:macta:problem:{code}")
    assert told["detail"].startswith("edits.1: ")
    assert words in told["detail"]
    assert choice is None or choice in told["choices"]
    assert api.get(CHANGES).json()["items"] == []  # all or none


def test_what_a_running_mission_needs_is_not_changed(api: TestClient, follow: Follow, team: FakeTeam) -> None:
    team.faults.stuck.add("yard_1")
    plan = follow(stated(api, "move sample_1 to bay_7"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    follow(f"/v1/missions/{mission}", "running")
    for edit in (gone("sample_1"), NEW | {"sample": {"name": "sample_9", "at": "bay_7"}}):
        refused = change(api, edit)
        assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:needed-by-mission")
        assert mission in refused.json()["detail"]
    changed(api, gone("sample_3"))


def test_a_change_from_an_outdated_edition_is_refused(api: TestClient) -> None:
    assert api.get(CHANGES).headers["etag"] == '"0"'
    assert change(api, NEW, if_match='"0"').headers["etag"] == '"1"'
    outdated = change(api, gone("sample_1"), if_match='"0"')
    assert (outdated.status_code, outdated.json()["type"]) == (412, "urn:macta:problem:world-changed")
    assert api.get(WORLD).json()["edition"] == 1


def test_a_change_is_undone_by_another_and_that_one_undone_makes_it_again(api: TestClient) -> None:
    before = facts(api).keys()
    changed(api, gone("sample_2"), NEW)
    after = facts(api).keys()
    undone = api.post(f"{CHANGES}/1:undo", json={"reason": "it was the wrong store"}).json()
    assert (undone["edition"], undone["undoes"]) == (2, 1)
    assert facts(api).keys() == before
    assert {one["name"] for one in api.get(WORLD).json()["layout"]["samples"]} == {
        f"sample_{number}" for number in (1, 2, 3, 4)
    }
    again = api.post(f"{CHANGES}/1:undo")
    assert (again.status_code, again.json()["type"]) == (409, "urn:macta:problem:already-undone")
    api.post(f"{CHANGES}/2:undo").raise_for_status()
    assert facts(api).keys() == after
    history = api.get(CHANGES).json()["items"]
    assert [(one["edition"], one["undoes"], one["undone_by"]) for one in history] == [
        (3, 2, None),
        (2, 1, 3),
        (1, None, 2),
    ]
    unknown = api.post(f"{CHANGES}/7:undo")
    assert (unknown.status_code, unknown.json()["choices"]) == (404, ["1", "2", "3"])


def test_an_undo_that_no_longer_fits_is_refused(api: TestClient) -> None:
    changed(api, gone("sample_1"))
    changed(api, NEW | {"sample": {"name": "sample_9", "at": "door_1"}})
    refused = api.post(f"{CHANGES}/1:undo")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:place-occupied")
    assert api.get(CHANGES).json()["items"][1]["undone_by"] is None


def test_a_sample_that_a_robot_sees_is_known_by_its_report_and_what_was_believed_there_is_not(
    api: TestClient, team: FakeTeam
) -> None:
    team.tell("yard_1", battery=1.0)
    report = SampleReport(sample="sample_9", place="door_1", at_s=team.clock.now_s())
    twice = [team.report("yard_1", report), team.report("yard_1", report)]
    until(lambda: set(twice) <= set(team.receipts))
    known = facts(api)
    assert known["in(sample_9, door_1)"] == "report of yard_1"
    assert "in(sample_1, door_1)" not in known
    assert [one["name"] for one in api.get(f"{WORLD}/unknown").json()["items"]] == ["sample_1"]
    (made,) = api.get(CHANGES).json()["items"]
    assert (made["actor"], made["reason"]) == ("yard_1", "yard_1 saw sample_9 in door_1")


def test_a_service_goes_on_with_the_changed_world_until_it_gets_another_file(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url)

    def serve(file: WorldFile, run: str) -> tuple[TestClient, Service]:
        world = RunningWorld(file=file, link=team.link, clock=team.clock, rate=None, run=run)
        service = Service(settings, [world], worker=worker)
        return TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}), service

    def samples(api: TestClient) -> set[str]:
        return {one["name"] for one in api.get(WORLD).json()["layout"]["samples"]}

    api, service = serve(world_file, "run-1")
    with service:
        changed(api, NEW, gone("sample_4"))
    api, service = serve(world_file, "run-1")
    with service:
        assert samples(api) == {"sample_1", "sample_2", "sample_3", "sample_9"}
        assert "in(sample_9, door_2)" in facts(api)
        until(lambda: team.editions[-1] == 1)
    api, service = serve(world_file, "run-2")
    with service:  # started anew, in the changed world
        assert "in(sample_9, door_2)" in facts(api)
        assert not any("sample_4" in fact for fact in facts(api))
    other = world_file.model_copy(update={"title": "Another store"})
    api, service = serve(other, "run-3")
    with service:
        assert samples(api) == {"sample_1", "sample_2", "sample_3", "sample_4"}
        newest = api.get(CHANGES).json()["items"][0]
        assert (newest["edition"], newest["reason"]) == (2, "the world file was replaced")
        refused = api.post(f"{CHANGES}/2:undo")
        assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:not-undoable")
