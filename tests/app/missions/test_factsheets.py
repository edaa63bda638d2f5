"""Robots that announce themselves with a factsheet: those of the world, and others that would come into it."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from pydantic import ValidationError

from app.composition import RunningWorld, Service
from app.missions import factsheets
from app.planning.pool.pool import PlanningWorker
from app.settings import Settings
from app.store import UnaskedRobotRow
from robots.wire import MAX_FACTSHEET_BYTES, Factsheet, FactsheetState
from robots.world import WorldFile
from robots.world.parts import STORE_TAGS
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.databases import ON_BOTH
from tests.waiting import until

Follow = Callable[..., dict[str, Any]]
WORLD = "/v1/worlds/sample_store"
CHANGES = f"{WORLD}/changes"
SHEETS = f"{WORLD}/factsheets"


def sheet(**values: Any) -> Factsheet:
    """What yard_1 of the world file is, and what is otherwise."""
    said: dict[str, Any] = {"repertoire": STORE_TAGS, "speed_m_s": 0.5, "turn_rad_s": 1.5}
    return Factsheet.model_validate(said | values)


def visitor(**values: Any) -> Factsheet:
    """What a robot is that no world has."""
    return sheet(start=(4.0, 1.4, -90.0), **values)


def announced(team: FakeTeam, robot: str, said: Factsheet) -> FactsheetState:
    """What the robot is told when it has announced itself."""
    told = len(team.replies)
    team.report(robot, said)
    until(lambda: len(team.replies) > told)
    name, answer = team.replies[-1]
    assert name == robot
    return answer.state


def facts(api: TestClient) -> dict[str, str]:
    """Each fact with its source."""
    items = api.get(f"{WORLD}/facts").json()["items"]
    return {f"{one['predicate']}({', '.join(one['args'])})": one["source"] for one in items}


def robot(api: TestClient, name: str) -> dict[str, Any]:
    return api.get(f"/v1/robots/{name}").raise_for_status().json()  # type: ignore[no-any-return]


def events(service: Service, kind: str) -> list[dict[str, Any]]:
    return [
        dict(event.data) | {"subject": event.subject}
        for event in service.events.since(0)
        if event.type == kind
    ]


def started(api: TestClient, follow: Follow, text: str) -> str:
    goal = f"/v1/goals/{api.post('/v1/goals', json={'text': text}).raise_for_status().json()['id']}"
    plan = follow(goal, "planned")["plan_id"]
    mission = api.post(f"/v1/plans/{plan}:approve", json={}).json()["mission_id"]
    return f"/v1/missions/{mission}"


@ON_BOTH
def test_what_a_robot_of_the_world_can_is_known_by_its_factsheet(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    before = facts(api)
    assert announced(team, "yard_1", sheet(number=3)) is FactsheetState.IN_FORCE
    known = facts(api)
    assert known.keys() == before.keys()
    its = {fact for fact, source in known.items() if source == "factsheet of yard_1"}
    assert {"can(yard_1, NAVIGATE)", "reaches(yard_1, door_1)"} <= its
    assert all("yard_1" in fact for fact in its)
    assert known["near(yard_1, home_yard_1)"] == "world file sample_store"
    kept = robot(api, "yard_1")["factsheet"]
    assert (kept["state"], kept["number"], kept["sheet"]["speed_m_s"]) == ("in_force", 3, 0.5)
    assert api.get(CHANGES).json()["items"] == []
    assert [one["outcome"] for one in events(service, "robot.announced")] == ["in_force"]
    assert robot(api, "yard_2")["factsheet"] is None


def test_a_robot_that_says_otherwise_changes_the_world_and_one_that_repeats_itself_does_not(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    said = sheet(number=1, speed_m_s=0.3, repertoire=("NAVIGATE",), sensors=("camera",))
    assert announced(team, "yard_1", said) is FactsheetState.IN_FORCE
    (made,) = api.get(CHANGES).json()["items"]
    assert (made["actor"], made["reason"]) == (
        "yard_1",
        "yard_1 announced itself: repertoire, sensors, speed_m_s",
    )
    assert {fact for fact in facts(api) if fact.startswith("can(yard_1,")} == {"can(yard_1, NAVIGATE)"}
    assert facts(api)["can(yard_1, NAVIGATE)"] == "factsheet of yard_1"
    assert robot(api, "yard_1")["factsheet"]["edition"] == 1
    assert announced(team, "yard_1", said) is FactsheetState.IN_FORCE
    team.report("yard_1", sheet(number=0))  # an earlier one that was long on its way
    assert announced(team, "yard_2", sheet()) is FactsheetState.IN_FORCE
    assert robot(api, "yard_1")["repertoire"] == ["NAVIGATE"]
    assert len(api.get(CHANGES).json()["items"]) == 1
    assert len(events(service, "robot.announced")) == 2
    api.post(f"{CHANGES}/1:undo").raise_for_status()
    assert "can(yard_1, DOCK)" in facts(api)


def test_a_robot_that_is_not_asked_is_asked_again_once_it_has_announced_itself_anew(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    with service.database.write() as session:
        session.add(UnaskedRobotRow(world="sample_store", robot="yard_1", reason="unknown kind status_query"))
    assert robot(api, "yard_1")["unasked"]["reason"] == "unknown kind status_query"
    assert announced(team, "yard_1", sheet(number=1)) is FactsheetState.IN_FORCE
    assert robot(api, "yard_1")["unasked"] is None


def test_a_robot_says_what_it_senses(
    api: TestClient, team: FakeTeam, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(factsheets, "MIN_INTERVAL_S", 0.0)
    assert "in" in robot(api, "yard_1")["senses"]
    assert announced(team, "yard_1", sheet(number=1, senses=())) is FactsheetState.IN_FORCE
    (made,) = api.get(CHANGES).json()["items"]
    assert made["reason"] == "yard_1 announced itself: senses"
    assert robot(api, "yard_1")["senses"] == []
    assert robot(api, "yard_1")["factsheet"]["sheet"]["senses"] == []
    assert announced(team, "yard_1", sheet(number=2)) is FactsheetState.IN_FORCE
    assert robot(api, "yard_1")["senses"] == [], "what is left out stays"
    assert announced(team, "yard_1", sheet(number=3, senses=("in", "clear"))) is FactsheetState.IN_FORCE
    assert robot(api, "yard_1")["senses"] == ["clear", "in"]
    assert announced(team, "yard_1", sheet(number=4, senses=("smell",))) is FactsheetState.REFUSED
    assert "unknown predicate 'smell'; choices: " in robot(api, "yard_1")["factsheet"]["reason"]


def test_a_simulated_robot_does_not_take_back_what_its_world_has_yet_to_take_up(
    api: TestClient, team: FakeTeam
) -> None:
    edit = {"edit": "change_robot", "name": "yard_1", "speed_m_s": 0.2}
    api.post(CHANGES, json={"reason": "a test", "edits": [edit]}).raise_for_status()
    early = team.report("yard_1", sheet(number=0, edition=0))
    until(lambda: early in team.receipts)
    assert len(api.get(CHANGES).json()["items"]) == 1
    assert announced(team, "yard_1", sheet(number=1, edition=1, speed_m_s=0.2)) is FactsheetState.IN_FORCE
    assert len(api.get(CHANGES).json()["items"]) == 1


def test_what_a_running_mission_needs_is_changed_once_it_has_ended(
    api: TestClient, follow: Follow, team: FakeTeam, service: Service
) -> None:
    team.faults.stuck.add("yard_1")
    mission = started(api, follow, "move sample_1 to bay_7 with yard_1 and store_2")
    assert announced(team, "yard_1", sheet(number=1, repertoire=("NAVIGATE",))) is FactsheetState.POSTPONED
    kept = robot(api, "yard_1")["factsheet"]
    assert kept["state"] == "postponed"
    assert mission.rpartition("/")[2] in kept["reason"]
    assert "can(yard_1, DOCK)" in facts(api)
    team.faults.stuck.clear()
    follow(mission, "completed", "failed")
    until(lambda: robot(api, "yard_1")["factsheet"]["state"] == "in_force")
    assert "can(yard_1, DOCK)" not in facts(api)
    assert [one["outcome"] for one in events(service, "robot.announced")] == ["postponed", "in_force"]
    until(lambda: team.replies and team.replies[-1][1].state is FactsheetState.IN_FORCE)


@ON_BOTH
def test_a_robot_that_no_world_has_waits_until_an_operator_admits_it(
    api: TestClient, follow: Follow, team: FakeTeam, service: Service
) -> None:
    assert announced(team, "visitor_1", visitor()) is FactsheetState.ANNOUNCED
    assert api.get("/v1/robots/visitor_1").status_code == 404
    (waiting,) = api.get(SHEETS, params={"state": "announced"}).json()["items"]
    assert (waiting["robot"], waiting["reason"]) == ("visitor_1", "no world has it; an operator may admit it")
    assert api.get(CHANGES).json()["items"] == []
    admitted = api.post(f"{WORLD}/robots/visitor_1:admit", json={"comment": "it is ours"}).json()
    assert (admitted["state"], admitted["edition"], admitted["decided_by"]) == (
        "in_force",
        1,
        "administrator",
    )
    known = facts(api)
    assert known["can(visitor_1, TRANSPORT)"] == "factsheet of visitor_1"
    assert known["reaches(visitor_1, door_1)"] == "factsheet of visitor_1"
    (made,) = api.get(CHANGES).json()["items"]
    assert (made["actor"], made["reason"]) == ("administrator", "it is ours")
    assert made["edits"][0]["robot"]["external"] is True
    until(lambda: team.replies and team.replies[-1][1].state is FactsheetState.IN_FORCE)
    assert events(service, "robot.admitted") == [
        {
            "subject": "visitor_1",
            "world": "sample_store",
            "edition": 1,
            "actor": "administrator",
            "comment": "it is ours",
        }
    ]
    again = api.post(f"{WORLD}/robots/visitor_1:admit")
    assert (again.status_code, again.json()["type"]) == (409, "urn:macta:problem:robot-in-world")
    mission = started(api, follow, "move sample_1 to bay_7 with visitor_1 and store_2")
    assert follow(mission, "completed", "failed")["state"] == "completed"
    assert "NAVIGATE" in {deed[0] for deed in team.robots["visitor_1"].deeds}


def test_a_robot_that_is_removed_is_a_stranger_again(api: TestClient, team: FakeTeam) -> None:
    announced(team, "visitor_1", visitor())
    api.post(f"{WORLD}/robots/visitor_1:admit").raise_for_status()
    until(lambda: team.replies[-1][1].state is FactsheetState.IN_FORCE)
    edits = [{"edit": "remove_robot", "name": "visitor_1"}]
    api.post(CHANGES, json={"reason": "it has left", "edits": edits}).raise_for_status()
    assert api.get(SHEETS).json()["items"] == []
    assert announced(team, "visitor_1", visitor(number=1)) is FactsheetState.ANNOUNCED


def test_a_robot_that_an_operator_refuses_is_told_so_and_stays_refused_unless_it_changes(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    announced(team, "visitor_1", visitor())
    refused = api.post(f"{WORLD}/robots/visitor_1:refuse", json={"reason": "it leaks oil"}).json()
    assert (refused["state"], refused["reason"]) == ("refused", "it leaks oil")
    until(lambda: team.replies and team.replies[-1][1].state is FactsheetState.REFUSED)
    assert team.replies[-1][1].reason == "it leaks oil"
    assert announced(team, "visitor_1", visitor(number=1)) is FactsheetState.REFUSED
    assert announced(team, "visitor_1", visitor(number=2, speed_m_s=0.1)) is FactsheetState.ANNOUNCED
    assert [(one["actor"], one["reason"]) for one in events(service, "robot.refused")] == [
        ("administrator", "it leaks oil")
    ]
    api.post(f"{WORLD}/robots/visitor_1:refuse", json={"reason": "still"}).raise_for_status()
    assert api.post(f"{WORLD}/robots/visitor_1:admit").json()["state"] == "in_force"
    in_world = api.post(f"{WORLD}/robots/yard_1:refuse", json={"reason": "x"})
    assert (in_world.status_code, in_world.json()["type"]) == (404, "urn:macta:problem:robot-not-announced")


@pytest.mark.parametrize(
    ("name", "said", "words"),
    [
        ("visitor_1", sheet(), "does not say where it stands"),
        ("visitor_1", sheet(start=(40.0, 1.0, 0.0)), "in no compartment"),
        ("visitor_1", sheet(start=(1.4, 1.7, 0.0)), "robots.yard_1 and robots.visitor_1 start nearer"),
        ("visitor_1", sheet(start=(0.1, 1.4, 0.0)), "in walls.1"),
        ("visitor_1", visitor(repertoire=("FLY",)), "no packet of a repertoire has the tag 'FLY'"),
        ("visitor_1", visitor(speed_m_s=20.0), "speed_m_s: Input should be less than or equal to 2"),
        ("visitor_1", visitor(body="hovercraft"), "hovercraft"),
        ("visitor_1", visitor(home="home_9"), "unknown location 'home_9'"),
        ("visitor_1", visitor(compartment="attic"), "unknown compartment 'attic'"),
        ("door_1", visitor(), "the name door_1 is in use"),
        ("service", visitor(), "no robot may be named service"),
        ("Visitor", visitor(), "name: String should match pattern"),
        ("yard_1", sheet(body="wheeled"), "yard_1 is simulated with its body"),
        ("yard_1", sheet(repertoire=("FLY",)), "no packet of a repertoire has the tag 'FLY'"),
    ],
)  # fmt: skip
def test_a_robot_that_does_not_fit_the_world_is_refused_with_the_reason(
    api: TestClient, team: FakeTeam, name: str, said: Factsheet, words: str
) -> None:
    assert announced(team, name, said) is FactsheetState.REFUSED
    assert words in team.replies[-1][1].reason
    (kept,) = api.get(SHEETS).json()["items"]
    assert (kept["state"], kept["reason"]) == ("refused", team.replies[-1][1].reason)
    assert api.get(CHANGES).json()["items"] == []
    refused = api.post(f"{WORLD}/robots/{name}:admit")
    assert (refused.status_code in (409, 422), words in refused.json()["detail"]) == (True, True)


def test_only_so_many_strangers_are_kept_and_a_refused_one_makes_room(
    api: TestClient, team: FakeTeam, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(factsheets, "MAX_OUTSIDE", 2)
    announced(team, "visitor_1", visitor())
    announced(team, "visitor_2", visitor())
    team.patient = False  # what is held back would be said again, and be answered beside the one refused
    team.report("visitor_3", visitor())
    team.patient = True
    assert announced(team, "yard_1", sheet()) is FactsheetState.IN_FORCE
    assert {one["robot"] for one in api.get(SHEETS).json()["items"]} == {"visitor_1", "visitor_2", "yard_1"}
    api.post(f"{WORLD}/robots/visitor_1:refuse", json={"reason": "too many"}).raise_for_status()
    until(lambda: team.replies and team.replies[-1][1].state is FactsheetState.REFUSED)
    assert announced(team, "visitor_3", visitor(number=1)) is FactsheetState.ANNOUNCED
    assert {one["robot"] for one in api.get(SHEETS).json()["items"]} == {"visitor_2", "visitor_3", "yard_1"}


@pytest.mark.parametrize(
    "values",
    [
        {"body": {"kind": "velocity", "notes": "x" * MAX_FACTSHEET_BYTES}},
        {"body": {"kind": "velocity", "notes": "\x00"}},
        {"body": {"kind": "velocity", "acceleration_m_s2": float("nan")}},
        {"repertoire": ["NAVIGATE"] * 300},
    ],
)
def test_a_factsheet_that_cannot_be_kept_is_no_message(values: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        sheet(**values)


@pytest.fixture
def open_service(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> Iterator[Service]:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url, admission="all")
    world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
    with Service(settings, [world], worker=worker) as service:
        yield service


def test_all_robots_that_fit_are_admitted_if_the_settings_say_so(
    open_service: Service, team: FakeTeam
) -> None:
    api = TestClient(open_service.api, headers={"authorization": f"Bearer {TOKEN}"})
    assert announced(team, "visitor_1", visitor()) is FactsheetState.IN_FORCE
    assert facts(api)["can(visitor_1, TRANSPORT)"] == "factsheet of visitor_1"
    assert robot(api, "visitor_1")["factsheet"]["edition"] == 1
    assert [one["actor"] for one in events(open_service, "robot.admitted")] == [None]
    assert announced(team, "visitor_2", visitor(compartment="attic")) is FactsheetState.REFUSED


def test_a_robot_that_came_into_an_earlier_world_file_is_a_stranger_to_the_next(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url, admission="all")
    other = world_file.model_copy(update={"title": "Another store"})
    for file, run, state in ((world_file, "run-1", "in_force"), (other, "run-2", "announced")):
        world = RunningWorld(file=file, link=team.link, clock=team.clock, rate=None, run=run)
        with Service(settings, [world], worker=worker):
            assert announced(team, "visitor_1", visitor()) is FactsheetState(state)
            assert announced(team, "yard_1", sheet(number=7)) is FactsheetState.IN_FORCE
        settings = settings.model_copy(update={"admission": "operator"})


def test_a_robot_says_the_same_again_in_each_run(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam, worker: PlanningWorker
) -> None:
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url)
    for run in ("run-1", "run-2"):
        world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=run)
        with Service(settings, [world], worker=worker) as service:
            api = TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"})
            assert facts(api)["can(yard_1, NAVIGATE)"] == "world file sample_store"
            assert announced(team, "yard_1", sheet(number=5)) is FactsheetState.IN_FORCE
            assert facts(api)["can(yard_1, NAVIGATE)"] == "factsheet of yard_1"
