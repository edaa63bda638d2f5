"""Numeric facts over the API: listed, corrected, and told by robots' batteries, moves and readings."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.composition import RunningWorld, Service
from app.packs.find import load_packs
from app.planning.goal_service import GoalRequest
from app.settings import Settings
from planner.engines.registry import engine_named
from robots.wire import ReadingResult
from robots.world import WorldFile, load_world
from tests.app.conftest import TOKEN
from tests.app.fake_robots import FakeTeam
from tests.app.scripted import InProcessWorker
from tests.databases import ON_BOTH
from tests.waiting import awaited, read_until

NUMBERS = "/v1/worlds/sample_store/numbers"
Follow = Callable[..., dict[str, Any]]


@pytest.fixture
def world_file() -> WorldFile:
    file = load_world("sample_store")
    robots = tuple(
        one.model_copy(update={"battery": 0.5}) if one.name == "yard_2" else one for one in file.robots
    )
    return file.model_copy(update={"robots": robots})


def numbers(api: TestClient) -> dict[str, dict[str, Any]]:
    items = api.get(NUMBERS).json()["items"]
    return {f"{one['quantity']}({', '.join(one['args'])})": one for one in items}


def state(api: TestClient, quantity: str, args: list[str], value: float, **headers: str) -> Any:
    body = {"numbers": [{"quantity": quantity, "args": args, "value": value}], "comment": "measured"}
    return api.put(NUMBERS, json=body, headers=headers)


def told(service: Service, kind: str) -> list[dict[str, Any]]:
    return [row.data for row in service.events.since(0) if row.type == kind]


def test_a_world_begins_with_batteries_loads_and_numbers_of_samples(api: TestClient) -> None:
    known = numbers(api)
    assert {name: known[name]["value"] for name in known if name.startswith("battery")} == {
        "battery(store_1)": 1,
        "battery(store_2)": 1,
        "battery(yard_1)": 1,
        "battery(yard_2)": 0.5,
    }
    assert known["samples(door_1)"]["value"] == 1
    assert known["samples(bay_7)"]["value"] == 0
    assert "samples(home_yard_1)" not in known
    assert known["load(yard_1)"]["counted"]
    assert known["battery(yard_2)"]["text"] == "yard_2's battery is at 50 %"
    assert known["battery(yard_2)"]["source"] == "world file sample_store"


def test_the_answer_is_of_the_version_that_its_etag_names(api: TestClient) -> None:
    before = api.get(NUMBERS)
    facts = api.get("/v1/worlds/sample_store/facts").headers["etag"]
    answer = state(api, "battery", ["yard_1"], 0.7, **{"If-Match": before.headers["etag"]})
    assert answer.status_code == 200
    after = api.get(NUMBERS)
    assert after.headers["etag"] == answer.headers["etag"] != before.headers["etag"]
    assert after.json() == answer.json()
    assert numbers(api)["battery(yard_1)"]["version"] == after.json()["version"]
    outdated = state(api, "battery", ["yard_1"], 0.6, **{"If-Match": before.headers["etag"]})
    assert (outdated.status_code, outdated.json()["type"]) == (412, "urn:macta:problem:numbers-changed")
    assert api.get("/v1/worlds/sample_store/facts").headers["etag"] == facts, "the facts are as they were"


def test_a_correction_is_told_with_who_made_it(api: TestClient, service: Service) -> None:
    assert state(api, "battery", ["yard_1"], 0.25).status_code == 200
    assert numbers(api)["battery(yard_1)"]["source"] == "operator administrator"
    assert told(service, "world.numbers_corrected") == [
        {"actor": "administrator", "comment": "measured", "stated": ["yard_1's battery is at 25 %"]}
    ]


@pytest.mark.parametrize(
    ("quantity", "args", "value", "code", "choice"),
    [
        ("batery", ["yard_1"], 0.5, "unknown-quantity", "battery"),
        ("battery", ["yard_9"], 0.5, "unknown-name", "yard_1"),
        ("battery", ["bay_7"], 0.5, "unknown-name", "yard_1"),
        ("battery", ["yard_1", "yard_2"], 0.5, "malformed-number", None),
        ("battery", ["yard_1"], 1.01, "out-of-range", None),
        ("battery", ["yard_1"], -0.01, "out-of-range", None),
        ("battery", ["yard_1"], True, "malformed-request", None),
        ("load", ["yard_1"], 1, "counted-number", "battery"),
        ("samples", ["bay_7"], 1, "counted-number", "battery"),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(
    api: TestClient, quantity: str, args: list[str], value: float, code: str, choice: str | None
) -> None:
    before = api.get(NUMBERS).json()
    body = {
        "numbers": [
            {"quantity": "battery", "args": ["yard_2"], "value": 0.9},
            {"quantity": quantity, "args": args, "value": value},
        ]
    }
    answer = api.put(NUMBERS, json=body)
    assert (answer.status_code, answer.json()["type"]) == (422, f"urn:macta:problem:{code}")
    assert choice is None or choice in answer.json()["choices"]
    assert api.get(NUMBERS).json() == before


def test_one_number_is_not_stated_to_be_two(api: TestClient) -> None:
    battery = {"quantity": "battery", "args": ["yard_1"]}
    answer = api.put(NUMBERS, json={"numbers": [{**battery, "value": 0.1}, {**battery, "value": 0.2}]})
    assert answer.json()["type"] == "urn:macta:problem:contradicting-numbers"


def test_numbers_of_an_unknown_world_are_not_found(api: TestClient) -> None:
    assert api.get("/v1/worlds/nowhere/numbers").status_code == 404
    body = {"numbers": [{"quantity": "battery", "args": ["yard_1"], "value": 0.5}]}
    assert api.put("/v1/worlds/nowhere/numbers", json=body).status_code == 404


def test_a_mission_moves_the_counts_with_the_sample(
    api: TestClient, follow: Follow, service: Service
) -> None:
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    mission = follow(f"/v1/goals/{goal['id']}", "finished")["mission_id"]
    known = numbers(api)
    assert known["samples(bay_7)"]["value"] == 1
    assert known["samples(door_1)"]["value"] == 0
    assert {known[f"load({robot})"]["value"] for robot in ("yard_1", "yard_2", "store_1", "store_2")} == {0}
    assert known["samples(bay_7)"]["source"].startswith("report of store_")
    loads = [
        one["value"]
        for data in told(service, "world.numbers_changed")[1:]
        for one in data["changed"]
        if one["quantity"] == "load" and one["before"] is not None
    ]
    assert sorted(loads) == [0, 0, 1, 1], "two robots have carried it"
    recorded = read_until(
        api,
        f"/v1/missions/{mission}/replay",
        lambda replay: replay.get("numbers", [{}])[-1].get("values", {}).get("samples(bay_7)") == 1,
    )
    assert recorded["numbers"][-1]["values"]["battery(yard_2)"] == 0.5


def test_a_robots_battery_is_recorded_as_it_tells(api: TestClient, service: Service, team: FakeTeam) -> None:
    team.tell("yard_1", battery=0.6)
    known = awaited(lambda: numbers(api), lambda found: found["battery(yard_1)"]["value"] == 0.6)
    assert known["battery(yard_1)"]["source"] == "report of yard_1"
    assert known["battery(yard_2)"]["source"] == "world file sample_store"


def test_recruiting_leaves_out_a_silent_robot_whose_battery_is_known_to_be_low(
    api: TestClient, follow: Follow
) -> None:
    assert state(api, "battery", ["yard_1"], 0.1).status_code == 200
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7"}).json()
    planned = follow(f"/v1/goals/{goal['id']}", "planned")
    plan = api.get(f"/v1/plans/{planned['plan_id']}").json()
    assert "yard_2" in plan["robots"]
    assert "yard_1" not in plan["robots"]
    state(api, "battery", ["yard_2"], 0.1)
    other = api.post("/v1/goals", json={"text": "move sample_2 to door_2"}).json()
    assert "its battery at 10%" in follow(f"/v1/goals/{other['id']}", "waiting")["reason"]
    state(api, "battery", ["yard_2"], 0.9)
    follow(f"/v1/goals/{other['id']}", "planned")


LOOKING = """\
predicates:
  looked_at: {arguments: {location: location}}
quantities:
  clutter: {arguments: {location: location}, unit: share, range: [0, 1]}
actions:
  - identifier: 1
    name: LOOK
    parameters: [{name: robot, type: robot}, {name: ref, type: location}]
    agents: [robot]
    preconditions: ["robot_position(robot, near, ref)", "can(robot, TRACK)", "battery(robot) >= 0.6"]
    delete: []
    intended_effects: ["looked_at(ref)"]
    other_effects: []
    duration: 4
    description: "{robot} looks at {ref}"
"""


@pytest.fixture
def looking(
    tmp_path: Path, database_url: str, world_file: WorldFile, team: FakeTeam
) -> Callable[[], Service]:
    """Services in turn with a pack whose one action needs a battery of 60 %."""
    folder = tmp_path / "looking"
    folder.mkdir()
    (folder / "pack.yaml").write_text('name: looking\nversion: "1.0"\nabout: Looks.\nneeds: {store: "1.0"}\n')
    (folder / "knowledge_base.yaml").write_text(LOOKING)
    settings = Settings(data=tmp_path, token=TOKEN, database_url=database_url, packs=(str(folder),))
    world = RunningWorld(file=world_file, link=team.link, clock=team.clock, rate=None, run=team.run)
    worker = InProcessWorker(engine_named("macta", load_packs([str(folder)]).knowledge_base()))
    return lambda: Service(settings, [world], worker=worker)


@ON_BOTH
def test_a_reading_becomes_a_number_and_outlasts_a_restart(
    looking: Callable[[], Service], team: FakeTeam
) -> None:
    team.brings["RELEASE2"] = (
        ReadingResult(name="clutter", of="bay_7", value=0.42),
        ReadingResult(name="clutter", of="bay_8", value=7.0),
        ReadingResult(name="clutter", of="yard_1", value=0.5),
        ReadingResult(name="light_lx", of="bay_7", value=412.0, unit="lx"),
    )

    def known(service: Service) -> dict[str, tuple[float, str, float]]:
        rows, _ = service.worlds.numbers("sample_store")
        return {row.term: (row.value, row.source, row.at_s) for row in rows}

    with looking() as service:
        request = GoalRequest(world="sample_store", text="move sample_1 to bay_7", auto_approve=True)
        goal = service.goals.submit(request, actor="test").id
        awaited(lambda: service.goals.get(goal), lambda found: found.state == "finished")
        before = known(service)
        value, source, at_s = before["clutter(bay_7)"]
        assert value == 0.42
        assert source.startswith("report of ")
        assert at_s > 0
        assert not {"clutter(bay_8)", "clutter(yard_1)", "light_lx(bay_7)"} & before.keys()
    with looking() as service:
        assert known(service) == before


def test_a_plan_rests_on_the_numbers_that_its_actions_need(looking: Callable[[], Service]) -> None:
    with looking() as service, TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api:

        def plan() -> dict[str, Any]:
            body = {"goal": [{"predicate": "looked_at", "args": ["door_1"]}]}
            goal = api.post("/v1/goals", json=body).json()["id"]
            decided = {"planned", "unsolvable", "waiting"}
            return awaited(
                lambda: api.get(f"/v1/goals/{goal}").json(), lambda found: found["state"] in decided
            )

        goal = plan()
        assert api.get(f"/v1/plans/{goal['plan_id']}").json()["robots"] == ["yard_1"], "yard_2 has 50 %"
        assert state(api, "battery", ["yard_1"], 0.55).status_code == 200
        refused = api.post(f"/v1/plans/{goal['plan_id']}:approve", json={})
        assert refused.status_code == 409
        assert "battery(yard_1) >= 0.6 is no longer true: it is 0.55, operator " in refused.json()["detail"]
        state(api, "battery", ["yard_1"], 0.25)
        lacking = plan()
        assert lacking["state"] == "unsolvable"
        assert lacking["reason"] == (
            "LOOK needs battery(robot) >= 0.6; it is 0.25 for yard_1 and 0.5 for yard_2"
        )
        state(api, "battery", ["yard_2"], 0.6)
        again = plan()
        assert api.get(f"/v1/plans/{again['plan_id']}").json()["robots"] == ["yard_2"]


def test_a_goal_may_ask_for_robots_with_a_number_of_at_least_so_much(api: TestClient, follow: Follow) -> None:
    def submit(least: float) -> str:
        body = {"text": "move sample_2 to door_2", "constraints": {"at_least": {"battery": least}}}
        return f"/v1/goals/{api.post('/v1/goals', json=body).json()['id']}"

    planned = follow(submit(0.6), "planned")
    plan = api.get(f"/v1/plans/{planned['plan_id']}").json()
    assert "yard_1" in plan["robots"]
    assert "yard_2" not in plan["robots"]
    assert planned["constraints"]["at_least"] == {"battery": 0.6}
    for robot in ("yard_1", "yard_2"):
        state(api, "battery", [robot], 0.55)
    lacking = follow(submit(0.6), "unsolvable")["reason"]
    assert lacking.endswith("only with robots of battery >= 0.6")


def test_a_goal_asks_for_numbers_of_robots_only(api: TestClient) -> None:
    for quantity in ("batery", "samples"):
        body = {"text": "move sample_2 to door_2", "constraints": {"at_least": {quantity: 0.4}}}
        answer = api.post("/v1/goals", json=body)
        assert (answer.status_code, answer.json()["type"]) == (422, "urn:macta:problem:unknown-quantity")
        assert set(answer.json()["choices"]) == {"battery", "load"}


def test_a_goal_asks_for_no_more_than_a_number_can_be(api: TestClient) -> None:
    body = {"text": "move sample_2 to door_2", "constraints": {"at_least": {"battery": 1.5}}}
    answer = api.post("/v1/goals", json=body)
    assert (answer.status_code, answer.json()["type"]) == (422, "urn:macta:problem:out-of-range")
    assert answer.json()["detail"].endswith("battery is 0 to 1, not 1.5")


def test_what_follows_from_a_number_is_not_stated_as_a_fact(looking: Callable[[], Service]) -> None:
    with looking() as service, TestClient(service.api, headers={"authorization": f"Bearer {TOKEN}"}) as api:
        facts = [{"predicate": "battery_at_least_0_6", "args": ["yard_2"]}]
        answer = api.put("/v1/worlds/sample_store/facts", json={"facts": facts})
        assert (answer.status_code, answer.json()["type"]) == (422, "urn:macta:problem:malformed-fact")
        assert "stands for battery(yard_2) >= 0.6" in answer.json()["detail"]
