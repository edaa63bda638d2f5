"""Worlds that operators change while missions run: checked, recorded, undone, and gone on with after a restart."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import text

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import ConversationRow, DialogueRow
from robots.wire import SampleReport
from robots.world import WorldFile
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH, ON_POSTGRESQL
from tests.waiting import read_until, until

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
    check = api.post(f"{CHANGES}:check", json={"edits": edits, "reason": "sold"}).raise_for_status().json()
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
        (
            {"edit": "remove_zone", "name": "spill"},
            404,
            "unknown-zone",
            "unknown zone 'spill'",
            None,
        ),
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


def test_the_recording_of_a_mission_has_the_world_as_it_became(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("yard_1")
    plan = follow(stated(api, "move sample_1 to bay_7"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    follow(f"/v1/missions/{mission}", "running")
    replay = f"/v1/missions/{mission}/replay"
    read_until(api, replay, lambda told: told.get("world") and told.get("samples"))
    changed(api, NEW, {"edit": "move_place", "name": "bay_12", "at": [7.5, 7.8]})

    def recorded() -> dict[str, Any]:
        return api.get(replay).json()  # type: ignore[no-any-return]

    until(lambda: {one["name"] for one in recorded()["world"]["layout"]["samples"]} >= {"sample_9"})
    places = {place["name"]: place["at"] for place in recorded()["world"]["layout"]["locations"]}
    assert places["bay_12"] == [7.5, 7.8]
    until(lambda: recorded()["samples"][-1]["lying"].get("sample_9") == "door_2")
    assert "sample_9" not in recorded()["samples"][0]["lying"]


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


HOME = {"name": "home_yard_3", "kind": "home", "at": [4, 0.6], "approach_deg": [90], "capacity": 0}
ROBOT = {"name": "yard_3", "compartment": "yard", "start": [4, 1.4, -90], "home": "home_yard_3"}
NEW_HOME = {"edit": "add_place", "place": HOME}
NEW_ROBOT = {"edit": "add_robot", "robot": ROBOT}


def test_a_robot_that_is_added_is_recruited_and_one_that_is_removed_is_not(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    changed(api, NEW_HOME, NEW_ROBOT)
    known = facts(api)
    assert known["near(yard_3, home_yard_3)"] == "operator administrator"
    assert "reaches(yard_3, door_1)" in known
    (robot,) = (one for one in api.get("/v1/robots").json()["items"] if one["id"] == "yard_3")
    assert (robot["world"], "door_2" in robot["reach"]) == ("sample_store", True)
    assert api.get("/v1/robots/yard_3/tuning").status_code == 200
    changed(api, {"edit": "remove_robot", "name": "yard_1"}, {"edit": "remove_robot", "name": "yard_2"})
    assert {one["id"] for one in api.get("/v1/robots").json()["items"]} == {"store_1", "store_2", "yard_3"}
    assert not any("yard_1" in fact for fact in facts(api))
    goal = follow(stated(api, "move sample_1 to bay_7"), "planned")
    plan = api.get(f"/v1/plans/{goal['plan_id']}").json()
    assert {robot for action in plan["actions"] for robot in action["agents"]} == {"yard_3", "store_2"}
    team.faults.stuck.add("yard_3")
    mission = api.post(f"/v1/plans/{goal['plan_id']}:approve", json={}).json()["mission_id"]
    refused = change(api, {"edit": "remove_robot", "name": "yard_3"})
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:needed-by-mission")
    team.faults.stuck.clear()
    assert follow(f"/v1/missions/{mission}", "completed", "failed")["state"] == "completed"
    api.post(f"{CHANGES}/2:undo").raise_for_status()
    assert "near(yard_1, home_yard_1)" in facts(api)


@ON_POSTGRESQL
def test_a_robot_is_removed_while_its_answer_to_a_person_is_recorded(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    """Both lock the conversation before the dialogue."""
    team.tell("yard_2", battery=1.0)
    asked = api.post("/v1/robots/yard_2/dialogues", json={"text": "where are you?"}).json()["id"]
    waits = text(
        "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND wait_event_type = 'Lock'"
    )

    def is_waiting() -> bool:
        with service.database.read() as session:
            return bool(session.scalar(waits))

    with ThreadPoolExecutor(1) as other:
        with service.database.write() as session:
            conversation = session.get_one(DialogueRow, asked).conversation
            session.get_one(ConversationRow, (conversation, "yard_2"), with_for_update=True)
            removed = other.submit(change, api, {"edit": "remove_robot", "name": "yard_2"})
            until(is_waiting)
            assert session.get(DialogueRow, asked, with_for_update=True, populate_existing=True) is not None
        assert removed.result().status_code == 200
    assert api.get(f"/v1/robots/yard_2/dialogues/{asked}").status_code == 404


def test_a_place_is_added_moved_and_removed(api: TestClient, follow: Follow) -> None:
    new = {"name": "bay_13", "kind": "bay", "at": [7.5, 4.4], "approach_deg": [180]}
    changed(
        api, {"edit": "add_place", "place": new}, {"edit": "move_place", "name": "bay_7", "at": [4.5, 5.0]}
    )
    assert "reaches(store_2, bay_13)" in facts(api)
    assert "vacant(bay_13)" in facts(api)
    goal = stated(api, "move sample_4 to bay_13")
    plan = follow(goal, "planned")["plan_id"]
    at = {place["name"]: place["at"] for place in api.get(WORLD).json()["layout"]["locations"]}
    assert (at["bay_13"], at["bay_7"]) == ([7.5, 4.4], [4.5, 5.0])
    changed(api, {"edit": "remove_place", "name": "bay_13"})
    assert not any("bay_13" in fact for fact in facts(api))
    assert api.post(f"/v1/plans/{plan}:approve", json={}).status_code == 409
    for edition in (2, 1):
        api.post(f"{CHANGES}/{edition}:undo").raise_for_status()
    assert {place["name"] for place in api.get(WORLD).json()["layout"]["locations"]} == at.keys() - {"bay_13"}


def test_a_robot_at_a_place_that_is_moved_stands_where_it_stood(api: TestClient) -> None:
    changed(api, {"edit": "move_place", "name": "home_yard_1", "at": [0.6, 1.2]})
    assert "near(yard_1, yard_1_spot)" in facts(api)
    assert "near(yard_1, home_yard_1)" not in facts(api)


ZONE_ELSEWHERE = {"edit": "add_zone", "zone": {"name": "field_9", "x": [50, 51], "y": [0, 1]}}


def of_robot(name: str, **values: Any) -> dict[str, Any]:
    return {"edit": "change_robot", "name": name, **values}


def test_a_robot_is_changed_where_it_stands_and_its_change_undone(api: TestClient, follow: Follow) -> None:
    before = facts(api).keys()
    made = changed(api, of_robot("yard_1", speed_m_s=0.2, repertoire=["NAVIGATE"], home=None))
    assert made["edits"] == [of_robot("yard_1", speed_m_s=0.2, repertoire=["NAVIGATE"], home=None)]
    known = facts(api)
    assert {fact for fact in known if fact.startswith("can(yard_1,")} == {"can(yard_1, NAVIGATE)"}
    assert "near(yard_1, yard_1_spot)" in known  # it stands where its home was
    assert "reaches(yard_1, home_yard_1)" not in known
    assert api.get("/v1/robots/yard_1").json()["repertoire"] == ["NAVIGATE"]
    goal = follow(stated(api, "move sample_1 to bay_7"), "planned")
    plan = api.get(f"/v1/plans/{goal['plan_id']}").json()
    assert "yard_1" not in {robot for action in plan["actions"] for robot in action["agents"]}
    undone = api.post(f"{CHANGES}/1:undo").raise_for_status().json()
    (back,) = undone["edits"]
    assert (back["speed_m_s"], back["home"]) == (0.5, "home_yard_1")
    assert before - facts(api).keys() == {"near(yard_1, home_yard_1)"}  # it stays where it is by now
    assert facts(api).keys() - before == {"near(yard_1, yard_1_spot)", "clear(home_yard_1, yard)"}


def test_a_plan_is_out_of_date_once_its_robot_can_no_longer_do_it(api: TestClient, follow: Follow) -> None:
    plan = follow(stated(api, "move sample_1 to bay_7 with yard_1 and store_2"), "planned")["plan_id"]
    edits = [of_robot("yard_1", repertoire=["NAVIGATE"])]
    assert api.post(f"{CHANGES}:check", json={"edits": edits}).json()["outdated_plans"] == [plan]


def test_a_robot_that_a_running_mission_needs_is_not_changed(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.stuck.add("yard_1")
    plan = follow(stated(api, "move sample_1 to bay_7 with yard_1 and store_2"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    refused = change(api, of_robot("yard_1", speed_m_s=0.2))
    assert (refused.status_code, refused.json()["thing"]) == (409, "yard_1")
    assert mission in refused.json()["detail"]
    changed(api, of_robot("yard_2", speed_m_s=0.2))


def test_a_robot_stays_in_its_area_unless_it_stands_in_the_new_one(api: TestClient) -> None:
    elsewhere = of_robot("yard_1", compartment="store", home=None, start=[1.5, 4.0, 0])
    refused = change(api, elsewhere)
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:macta:problem:robot-outside-area")
    assert "home_yard_1" in refused.json()["detail"]


@pytest.mark.parametrize(
    ("edit", "code", "words"),
    [
        (of_robot("fred", speed_m_s=0.2), "unknown-robot", "unknown robot 'fred'"),
        (of_robot("yard_1", speed_m_s=None), "world-does-not-fit", "speed_m_s"),
        (of_robot("yard_1", home="home_9"), "world-does-not-fit", "unknown location 'home_9'"),
        (of_robot("yard_1", aisle="aisle_9"), "world-does-not-fit", "unknown aisle 'aisle_9'"),
        (of_robot("yard_1", start=[40, 1, 0]), "world-does-not-fit", "outside its area"),
        (of_robot("yard_1", repertoire=["FLY"]), "unknown-tag", "'FLY'"),
        (of_robot("yard_1", tuning={"FLY": {}}), "unfit-tuning", "unknown packet FLY"),
        ({**NEW_ROBOT, "robot": ROBOT | {"home": None, "tuning": {"FLY": {}}}}, "unfit-tuning", "unknown packet FLY"),
        ({**NEW_ROBOT, "robot": ROBOT | {"home": None, "rules": {"guard": "AGENT no"}}}, "unfit-rules", "guard:1:9:"),
        ({"edit": "remove_robot", "name": "fred"}, "unknown-robot", "unknown robot 'fred'"),
        (NEW_ROBOT, "world-does-not-fit", "unknown location 'home_yard_3'"),
        ({**NEW_ROBOT, "robot": ROBOT | {"home": None, "repertoire": ["FLY"]}}, "unknown-tag", "'FLY'"),
        ({**NEW_ROBOT, "robot": ROBOT | {"home": None, "start": [1.4, 1.7, 0]}}, "world-does-not-fit", "yard_1"),
        ({**NEW_ROBOT, "robot": ROBOT | {"name": "store_1"}}, "name-in-use", "the name store_1 is in use"),
        ({"edit": "remove_place", "name": "door_1"}, "place-holds-sample", "sample_1 lies in door_1"),
        ({"edit": "remove_place", "name": "home_yard_1"}, "place-is-home", "the home of yard_1"),
        ({"edit": "move_place", "name": "bay_7", "at": [4.5, 6.6]}, "world-does-not-fit", "0.00 m from locations.bay_"),
        ({"edit": "move_place", "name": "bay_7", "at": [40, 6.6]}, "world-does-not-fit", "lies in no compartment"),
        (ZONE_ELSEWHERE, "world-does-not-fit", "field_9 lies in no compartment"),
        ({"edit": "add_place", "place": HOME | {"name": "yard"}}, "name-in-use", "the name yard is in use"),
    ],
)  # fmt: skip
def test_robots_and_places_that_do_not_fit_are_refused(
    api: TestClient, edit: dict[str, Any], code: str, words: str
) -> None:
    refused = change(api, edit).json()
    assert refused["type"] == f"urn:macta:problem:{code}", refused
    assert refused["detail"].startswith("edits.0: ")
    assert words in refused["detail"]


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
        until(lambda: team.editions[-1:] == [1])
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


def test_nothing_is_planned_in_an_area_to_keep_out_of_until_it_is_opened(
    api: TestClient, follow: Follow
) -> None:
    spill = {"name": "spill", "x": [4.0, 5.0], "y": [4.5, 6.0], "rule": "keep_out"}  # around bay_7
    made = changed(api, {"edit": "add_zone", "zone": spill})
    refused = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"})
    assert refused.status_code == 422
    assert "bay_7, which is in spill, a zone to keep out of" in refused.json()["detail"]
    checked = api.post("/v1/goals:check", json={"text": "move sample_4 to any bay of aisle_2"}).json()
    assert [goal["args"][1] for goal in checked["goals"]] == ["bay_8"]
    undone = api.post(f"{CHANGES}/{made['edition']}:undo").json()
    assert undone["edits"] == [{"edit": "remove_zone", "name": "spill"}]
    assert follow(stated(api, "move sample_1 to bay_7"), "planned", "unsolvable")["state"] == "planned"


def test_an_area_with_a_place_that_a_mission_needs_is_refused(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    team.faults.silent.add("store_2")
    plan = follow(stated(api, "move sample_1 to bay_7"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    spill = {"name": "spill", "x": [4.0, 5.0], "y": [4.5, 6.0], "rule": "keep_out"}
    edit = {"edit": "add_zone", "zone": spill}
    refused = change(api, edit)
    assert (refused.status_code, refused.json()["thing"]) == (409, "bay_7")
    assert mission in refused.json()["detail"]


GATE = {"name": "gate", "x": [3.4, 4.6], "y": [0, 3.6], "rule": "one_robot"}
"""Across the yard, between its doors."""


@ON_BOTH
def test_a_plan_through_a_zone_that_is_new_is_out_of_date(api: TestClient, follow: Follow) -> None:
    plan = follow(stated(api, "send yard_1 to door_2"), "planned")["plan_id"]
    edit = {"edit": "add_zone", "zone": GATE}
    checked = api.post(f"{CHANGES}:check", json={"edits": [edit]}).json()
    assert checked["outdated_plans"] == [plan]
    changed(api, edit)
    refused = api.post(f"/v1/plans/{plan}:approve", json={})
    assert refused.status_code == 409
    assert "a1 enters gate, a zone for one robot, without regard to others" in refused.json()["detail"]
    goal = api.get(f"/v1/plans/{plan}").json()["goal_id"]
    repaired = follow(f"/v1/goals/{goal}", "planned")["plan_id"]
    (action,) = api.get(f"/v1/plans/{repaired}").json()["actions"]
    assert {"predicate": "zone_clear", "args": ["gate"]} in action["preconditions"]


@ON_BOTH
def test_a_mission_holds_the_zone_that_it_enters_and_others_wait_for_it(
    api: TestClient, follow: Follow, team: FakeTeam
) -> None:
    changed(api, {"edit": "add_zone", "zone": GATE})
    team.faults.silent.add("yard_1")
    plan = follow(stated(api, "send yard_1 to door_2"), "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    waiting = follow(stated(api, "send yard_2 to door_1"), "waiting", "planned")
    assert waiting["state"] == "waiting"
    assert mission in waiting["reason"]
    refused = change(api, {"edit": "remove_zone", "name": "gate"})
    assert (refused.status_code, refused.json()["thing"]) == (409, "gate")
    nook = {"name": "nook", "x": [5, 7], "y": [0, 1], "rule": "one_robot"}
    refused = change(api, {"edit": "add_zone", "zone": nook})
    assert (refused.status_code, refused.json()["thing"]) == (409, "door_2")
    free = follow(stated(api, "send yard_2 to interchange_2"), "planned", "waiting")
    assert free["state"] == "planned"


def test_the_history_is_read_page_by_page(api: TestClient) -> None:
    assert api.get(CHANGES).headers["etag"] == '"0"'
    made = changed(api, NEW)
    for edition in (made["edition"], made["edition"] + 1):
        api.post(f"{CHANGES}/{edition}:undo").raise_for_status()
    first = api.get(CHANGES, params={"limit": 2})
    assert first.headers["etag"] == '"3"'
    rest = api.get(CHANGES, params={"limit": 2, "after": first.json()["next"]}).json()
    assert [one["edition"] for one in (*first.json()["items"], *rest["items"])] == [3, 2, 1]
    assert rest["next"] is None
