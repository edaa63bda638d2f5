"""Worlds that are added and removed while the service and missions in other worlds run."""

import gc
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import AddedWorldRow
from robots.wire import Factsheet
from robots.world import WorldFile, world_yaml
from tests.app.conftest import TOKEN
from tests.app.declared import declared_errors
from tests.app.fake_robots import FakeTeam
from tests.app.world_hosts import TeamHost, hall
from tests.databases import ON_BOTH
from tests.waiting import ENDED, in_state, read_until, until

LIMIT = 4
Serve = Callable[..., AbstractContextManager[TestClient]]


@pytest.fixture
def host() -> TeamHost:
    return TeamHost()


@pytest.fixture
def serve(
    tmp_path: Path,
    database_url: str,
    world_file: WorldFile,
    team: FakeTeam,
    worker: PlanningWorker,
    host: TeamHost,
) -> Serve:
    """Services in turn on one record, started with the sample store and perhaps further worlds."""
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url, worlds=LIMIT)

    @contextmanager
    def begin(*others: WorldFile, fixed: bool = False) -> Iterator[TestClient]:
        worlds = [RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)]
        with FakeTeam() as idle:
            for other in others:
                worlds.append(
                    RunningWorld(file=other, link=idle.link, clock=idle.clock, rate=None, run="given")
                )
            with (
                Service(settings, worlds, worker=worker, host=None if fixed else host) as service,
                TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as client,
            ):
                client.event_hooks = {"response": [declared_errors(service.api)]}
                client.app_state["service"] = service
                yield client

    return begin


@pytest.fixture
def api(serve: Serve) -> Iterator[TestClient]:
    with serve() as client:
        yield client


def post(api: TestClient, file: WorldFile, **query: Any) -> Any:
    return api.post("/v1/worlds", json=file.model_dump(mode="json"), params=query)


def added(api: TestClient, file: WorldFile, **query: Any) -> dict[str, Any]:
    answer = post(api, file, **query)
    assert answer.status_code == 201, answer.text
    return answer.json()  # type: ignore[no-any-return]


def runs(api: TestClient, name: str) -> dict[str, Any]:
    return read_until(api, f"/v1/worlds/{name}", lambda world: world["status"] == "running")


def removed(api: TestClient, name: str, **query: Any) -> None:
    answer = api.delete(f"/v1/worlds/{name}", params=query)
    assert answer.status_code == 204, answer.text


def goal(api: TestClient, text: str, world: str, *, auto_approve: bool = True) -> str:
    body = {"text": text, "world": world, "auto_approve": auto_approve}
    answer = api.post("/v1/goals", json=body)
    assert answer.status_code == 202, answer.text
    return f"/v1/goals/{answer.json()['id']}"


def robots(api: TestClient) -> set[str]:
    return {one["name"] for one in api.get("/v1/robots").json()["items"]}


def names(api: TestClient) -> list[str]:
    return [one["id"] for one in api.get("/v1/worlds").json()["items"]]


def events(api: TestClient, kind: str) -> list[dict[str, Any]]:
    service: Service = api.app_state["service"]
    return [
        {"subject": row.subject, **row.data} for row in service.events.since(0, 10_000) if row.type == kind
    ]


def code(answer: Any) -> str:
    return str(answer.json()["type"]).rpartition(":")[2]


@ON_BOTH
def test_goals_are_reached_in_a_world_that_was_added_and_in_the_others_meanwhile(
    api: TestClient, host: TeamHost
) -> None:
    first = goal(api, "move sample_1 to bay_7", "sample_store")
    answer = post(api, hall("hall"), reason="a second hall")
    assert answer.status_code == 201
    assert answer.headers["location"] == "/v1/worlds/hall"
    assert answer.json()["edition"] == 1
    second = goal(api, "move sample_1 to bay_7", "hall")
    for one in (first, second):
        assert in_state(api, one, "finished")["outcome"] == "completed"
    assert names(api) == ["sample_store", "hall"]
    assert {f"hall_{robot}" for robot in ("yard_1", "store_2")} < robots(api)
    (event,) = events(api, "world.added")
    assert (event["subject"], event["actor"], event["reason"]) == ("hall", "administrator", "a second hall")
    (edition,) = api.get("/v1/worlds/hall/changes").json()["items"]
    assert (edition["edition"], edition["reason"]) == (1, "a second hall")
    assert not host.simulations["hall"].paused


def test_a_world_is_known_while_its_simulation_is_still_being_built(api: TestClient, host: TeamHost) -> None:
    host.built.clear()
    assert added(api, hall("hall"))["status"] == "starting"
    planned = goal(api, "move sample_1 to bay_7", "hall", auto_approve=False)
    assert in_state(api, planned, "planned")["plan_id"]
    read_until(api, "/v1/worlds/hall", lambda world: world["status_detail"] == "the team gets up")
    assert api.get("/readyz").json()["starting"] == ["hall"]
    host.built.set()
    runs(api, "hall")
    assert "starting" not in api.get("/readyz").json()


def test_a_world_that_cannot_be_built_says_why_and_is_removed(api: TestClient, host: TeamHost) -> None:
    host.broken.add("hall")
    added(api, hall("hall"))
    failed = read_until(api, "/v1/worlds/hall", lambda world: world["status"] == "failed")
    assert failed["status_detail"] == "hall cannot be built"
    assert api.get("/readyz").json()["failed"] == ["hall"]
    removed(api, "hall")
    assert "failed" not in api.get("/readyz").json()


@ON_BOTH
def test_a_world_comes_back_after_a_restart_until_it_is_removed(serve: Serve, host: TeamHost) -> None:
    with serve() as api:
        added(api, hall("hall"), reason="a second hall", rate=3)
        done = goal(api, "move sample_1 to bay_7", "hall")
        assert in_state(api, done, "finished")["outcome"] == "completed"
    with serve() as api:
        runs(api, "hall")
        assert host.rates["hall"] == 3
        believed = {
            (one["predicate"], *one["args"]) for one in api.get("/v1/worlds/hall/facts").json()["items"]
        }
        assert ("in", "sample_1", "bay_7") in believed
        assert not events(api, "world.removed")
        removed(api, "hall", reason="sold")
        assert host.forgotten == ["hall"]
        (event,) = events(api, "world.removed")
        assert (event["subject"], event["actor"], event["reason"]) == ("hall", "administrator", "sold")
    with serve() as api:
        assert names(api) == ["sample_store"]
        assert api.get(done).json()["outcome"] == "completed"


@ON_BOTH
def test_a_mission_goes_on_when_the_service_starts_again(serve: Serve, host: TeamHost) -> None:
    with serve() as api:
        added(api, hall("hall"))
        runs(api, "hall")
        host.simulations["hall"].team.faults.stuck = {one.name for one in hall("hall").robots}
        running = goal(api, "move sample_1 to bay_7", "hall")
        in_state(api, running, "committed")
    with serve() as api:
        assert in_state(api, running, "finished", "committed")["state"] == "committed"
        runs(api, "hall")
        mission = api.get("/v1/missions").json()["items"][0]["id"]
        api.post(f"/v1/missions/{mission}:cancel", json={}).raise_for_status()
        in_state(api, f"/v1/missions/{mission}", *ENDED, "unknown")


def test_its_history_stays_readable(api: TestClient) -> None:
    added(api, hall("hall"))
    done = goal(api, "move sample_1 to bay_7", "hall")
    mission = in_state(api, done, "finished")["mission_id"]
    plan = api.get(done).json()["plan_id"]
    removed(api, "hall")
    for path in (done, f"/v1/plans/{plan}", f"/v1/missions/{mission}", "/v1/worlds/hall/changes"):
        assert api.get(path).status_code == 200, path
    replay = read_until(
        api,
        f"/v1/missions/{mission}/replay",
        lambda replay: any(event["type"] == "mission.completed" for event in replay.get("events", ())),
    )
    assert replay["missions"][-1]["mission"]["state"] == "completed"
    assert api.get("/v1/worlds/hall").status_code == 404
    assert api.get("/v1/telemetry?world=hall").status_code == 404
    assert not any(robot.startswith("hall") for robot in robots(api))
    refused = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "world": "hall"})
    assert (refused.status_code, code(refused)) == (404, "unknown-world")


@ON_BOTH
def test_a_world_with_open_goals_or_missions_stays(api: TestClient, host: TeamHost) -> None:
    added(api, hall("hall"))
    undecided = goal(api, "move sample_1 to bay_7", "hall", auto_approve=False)
    in_state(api, undecided, "planned")
    refused = api.delete("/v1/worlds/hall")
    assert (refused.status_code, code(refused)) == (409, "world-in-use")
    assert undecided.rpartition("/")[2] in refused.json()["detail"]
    runs(api, "hall")
    host.simulations["hall"].team.faults.stuck = {one.name for one in hall("hall").robots}
    plan = api.get(undecided).json()["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    refused = api.delete("/v1/worlds/hall")
    assert (refused.status_code, refused.json()["thing"]) == (409, mission)
    assert names(api) == ["sample_store", "hall"]
    host.simulations["hall"].team.faults.stuck = set()
    in_state(api, f"/v1/missions/{mission}", *ENDED)
    removed(api, "hall")


def test_places_kept_empty_end_with_their_world(api: TestClient) -> None:
    added(api, hall("hall"))
    done = goal(api, "keep bay_7 empty until further notice", "hall")
    in_state(api, done, "finished", "planned")
    until(lambda: events(api, "hold.began"))
    removed(api, "hall", reason="sold")
    (ended,) = events(api, "hold.ended")
    assert (ended["world"], ended["why"], ended["comment"]) == ("hall", "world_removed", "sold")
    added(api, hall("hall"))
    kept = goal(api, "move sample_1 to bay_7", "hall")
    assert in_state(api, kept, "finished")["outcome"] == "completed"


def test_a_world_is_removed_while_a_mission_runs_in_another(api: TestClient, team: FakeTeam) -> None:
    team.faults.stuck = {"yard_1", "yard_2", "store_1", "store_2"}
    running = goal(api, "move sample_1 to bay_7", "sample_store")
    in_state(api, running, "committed")
    added(api, hall("hall"))
    runs(api, "hall")
    removed(api, "hall")
    team.faults.stuck = set()
    assert in_state(api, running, "finished")["outcome"] == "completed"


@ON_BOTH
def test_names_are_of_one_world_each(api: TestClient) -> None:
    refused = post(api, hall("sample_store"))
    assert (refused.status_code, code(refused)) == (409, "name-in-use")
    refused = post(api, hall("hall").model_copy(update={"robots": hall("hall", robots="hall").robots[:1]}))
    assert refused.status_code == 201
    refused = post(api, hall("annex", robots="hall"))
    assert (refused.status_code, refused.json()["thing"]) == (409, "hall_yard_1")
    assert "robots.0.name: hall has a robot hall_yard_1" in refused.json()["detail"]
    assert names(api) == ["sample_store", "hall"]
    removed(api, "hall")
    added(api, hall("annex", robots="hall"))


def test_a_world_of_the_start_is_not_removed(api: TestClient) -> None:
    refused = api.delete("/v1/worlds/sample_store")
    assert (refused.status_code, code(refused)) == (409, "world-of-the-start")
    refused = api.delete("/v1/worlds/nowhere")
    assert (refused.status_code, refused.json()["choices"]) == (404, ["sample_store"])


def test_more_worlds_than_the_limit_are_refused_with_the_number(api: TestClient) -> None:
    for index in range(LIMIT - 1):
        added(api, hall(f"hall_{index}"))
    refused = post(api, hall("annex"))
    assert (refused.status_code, code(refused)) == (429, "too-many-worlds")
    assert f"the limit is {LIMIT} (MACTA_WORLDS)" in refused.json()["detail"]
    removed(api, "hall_1")
    added(api, hall("annex"))


def test_a_file_that_is_given_at_the_start_counts_for_a_world_that_was_added(serve: Serve) -> None:
    with serve() as api:
        added(api, hall("hall", title="as added"))
        runs(api, "hall")
    with serve(hall("hall", title="as given")) as api:
        assert api.get("/v1/worlds/hall").json()["title"] == "as given"
        newest = api.get("/v1/worlds/hall/changes").json()["items"][0]
        assert (newest["edition"], newest["reason"]) == (2, "the world file was replaced")
        assert code(api.delete("/v1/worlds/hall")) == "world-of-the-start"
    with serve() as api:  # without the file the world is as it was last
        assert api.get("/v1/worlds/hall").json()["edition"] == 2
        removed(api, "hall")
    with serve() as api:
        assert names(api) == ["sample_store"]


def test_a_world_that_was_removed_runs_again_when_it_is_given_at_the_start(serve: Serve) -> None:
    with serve() as api:
        added(api, hall("hall"))
        removed(api, "hall")
    with serve(hall("hall")) as api:
        assert in_state(api, goal(api, "move sample_1 to bay_7", "hall", auto_approve=False), "planned")


@ON_BOTH
def test_a_world_of_the_same_name_begins_anew(api: TestClient) -> None:
    added(api, hall("hall", title="first"))
    in_state(api, goal(api, "move sample_1 to bay_7", "hall"), "finished")
    removed(api, "hall")
    again = added(api, hall("hall", title="second"))
    assert (again["title"], again["edition"]) == ("second", 2)
    facts = {(one["predicate"], *one["args"]) for one in api.get("/v1/worlds/hall/facts").json()["items"]}
    assert ("in", "sample_1", "bay_7") not in facts
    runs(api, "hall")
    assert in_state(api, goal(api, "move sample_1 to bay_7", "hall"), "finished")["outcome"] == "completed"


def test_places_are_kept_empty_in_a_world_that_was_added_until_it_is_removed(api: TestClient) -> None:
    def endings(name: str) -> list[str]:
        holds = api.get(f"/v1/worlds/{name}/holds", params={"state": "ended"}).json()["items"]
        return [hold["ending"] for hold in holds]

    added(api, hall("hall"))
    runs(api, "hall")
    first = api.get(goal(api, "keep bay_7 empty until further notice", "hall")).json()
    goal(api, "keep bay_8 empty until sample_1 is in bay_9", "hall")
    in_state(api, goal(api, "move sample_1 to bay_9", "hall"), "finished")
    until(lambda: endings("hall") == ["fact"])
    removed(api, "hall")
    assert [one["why"] for one in events(api, "hold.ended")] == ["fact", "world_removed"]
    assert events(api, "hold.ended")[-1]["subject"] == first["holds"][0]["id"]
    added(api, hall("hall"))
    assert api.get("/v1/worlds/hall/holds").json()["items"] == []


def test_the_worlds_of_a_service_without_a_host_are_fixed(serve: Serve) -> None:
    with serve(fixed=True) as api:
        assert code(post(api, hall("hall"))) == "worlds-fixed"


def test_nothing_is_left_of_worlds_that_were_removed(api: TestClient, host: TeamHost) -> None:
    service: Service = api.app_state["service"]

    def once(name: str) -> None:
        added(api, hall(name))
        runs(api, name)
        removed(api, name)

    once("first")
    told = len(service.database.committed)
    for index in range(5):
        once(f"brief_{index}")
    until(lambda: not any("brief_" in thread.name for thread in threading.enumerate()))
    gc.collect()
    assert len(service.database.committed) == told
    assert all(simulation.stopped for simulation in host.simulations.values())
    kept = [one for one in gc.get_objects() if isinstance(one, RunningWorld | WorldFile)]
    assert not [one for one in kept if getattr(one, "file", one).name.startswith("brief_")]
    with service.database.read() as session:
        assert session.get_one(AddedWorldRow, "brief_1").removed_by == "administrator"


def test_who_has_announced_itself_to_a_world_is_forgotten_with_it(api: TestClient, host: TeamHost) -> None:
    sheets = "/v1/worlds/hall/factsheets"
    added(api, hall("hall"))
    runs(api, "hall")
    said = Factsheet(repertoire=("NAVIGATE",), speed_m_s=0.4, turn_rad_s=1.0, start=(4.0, 1.4, -90.0))
    host.simulations["hall"].team.report("visitor_1", said)
    until(lambda: [one["state"] for one in api.get(sheets).json()["items"]] == ["announced"])
    removed(api, "hall")
    added(api, hall("hall"))
    runs(api, "hall")
    assert api.get(sheets).json()["items"] == []


def test_a_world_is_read_from_yaml_as_a_file_is(api: TestClient) -> None:
    text = world_yaml(hall("hall"))
    yaml = {"content-type": "application/yaml"}
    assert api.post("/v1/worlds", content=text, headers=yaml).status_code == 201
    assert api.get("/v1/worlds/hall").json()["title"] == "hall"


BAD = {
    "not-yaml": ("robots: [", "is not YAML"),
    "too-deep": ("a: " + "[" * 60 + "]" * 60, "nested more than 50 deep"),
    "no-world": ("[1, 2]", "does not contain a mapping"),
    "unknown-place": (
        world_yaml(hall("hall")).replace("at: door_1", "at: door_9", 1),
        "unknown location 'door_9'",
    ),
}


@pytest.mark.parametrize(("text", "words"), BAD.values(), ids=BAD)
@pytest.mark.parametrize("path", ["/v1/worlds", "/v1/worlds:check"])
def test_a_bad_file_is_refused_and_nothing_of_it_is_recorded(
    api: TestClient, path: str, text: str, words: str
) -> None:
    refused = api.post(path, content=text, headers={"content-type": "application/yaml"})
    assert (refused.status_code, code(refused)) == (422, "invalid-world"), refused.text
    assert words in refused.json()["detail"]
    assert names(api) == ["sample_store"]
    assert not events(api, "world.added")


def test_a_fault_is_named_with_its_place_and_the_choices(api: TestClient) -> None:
    robot = hall("hall").robots[2].model_copy(update={"repertoire": ("FLY",)})
    wrong = hall("hall").model_copy(update={"robots": (*hall("hall").robots[:2], robot)})
    refused = post(api, wrong).json()
    (error,) = refused["errors"]
    assert "robots.hall_store_1.repertoire.0: no packet of a repertoire has the tag 'FLY'" in error["message"]
    assert "choices: " in error["message"]


def test_characters_that_disguise_text_are_refused_also_when_yaml_escapes_them(api: TestClient) -> None:
    text = world_yaml(hall("hall", title="x")).replace("title: x", 'title: "a\\u202Eb"')
    refused = api.post("/v1/worlds", content=text, headers={"content-type": "application/yaml"})
    assert (refused.status_code, code(refused)) == (422, "malformed-request")
    assert "U+202E" in refused.json()["detail"]


def test_a_check_adds_nothing(api: TestClient) -> None:
    checked = api.post("/v1/worlds:check", json=hall("hall").model_dump(mode="json"))
    assert checked.json()["robots"][0] == "hall_yard_1"
    assert (
        code(api.post("/v1/worlds:check", json=hall("sample_store").model_dump(mode="json"))) == "name-in-use"
    )
    assert names(api) == ["sample_store"]


def test_worlds_come_and_go_under_load(api: TestClient) -> None:
    """Clients read and state goals without a pause; none gets an error that is not declared, or of the service."""
    failures: list[str] = []
    done = threading.Event()

    def read() -> None:
        while not done.is_set():
            for path in ("/v1/worlds", "/v1/robots", "/v1/goals", "/readyz", "/v1/executors"):
                answer = api.get(path)
                if answer.status_code >= 500:
                    failures.append(f"{path}: {answer.text}")

    readers = [threading.Thread(target=read) for _ in range(3)]
    for reader in readers:
        reader.start()
    stated = []
    try:
        for index in range(4):
            added(api, hall(f"hall_{index}"))
            stated.append(goal(api, "move sample_1 to bay_7", "sample_store", auto_approve=False))
            runs(api, f"hall_{index}")
            removed(api, f"hall_{index}")
    finally:
        done.set()
        for reader in readers:
            reader.join()
    assert not failures
    for one in stated:
        in_state(api, one, "planned", "waiting", "planning", "submitted")
