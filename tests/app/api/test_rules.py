"""An operator gives robots rule files."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from fastapi.testclient import TestClient

from app.composition import Service
from robots.deliberative.mind import Mind
from robots.deliberative.reader import digest_of
from robots.deliberative.terms import Term
from robots.physical.body import ALL_SENSORS, Pose, Sensor
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from tests.app.fake_robots import FakeRobot, FakeTeam
from tests.databases import ON_POSTGRESQL
from tests.waiting import read_until

RULES = "/v1/robots/yard_1/rules"
GUARD = "AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"
ALERT = "AGENT alert;\nPERCEPTOR hit IS bumped();\nBELIEF(hit) => COMMIT(adoptBelief(on_duty));\n"


def deliberate(team: FakeTeam, *, sensors: frozenset[str] = ALL_SENSORS) -> Mind:
    """yard_1 has a deliberative level from now on, that of simulated robots."""
    start = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
    profile = RobotProfile(name="yard_1", start=start, beacons={}, sensors=sensors)
    mind = Mind(profile, load_repertoire(), ())
    team.robots.setdefault("yard_1", FakeRobot()).mind = mind
    return mind


def put(api: TestClient, files: dict[str, str], **headers: str) -> Any:
    return api.put(RULES, json={"files": files, "comment": "at night"}, headers=headers)


def until(api: TestClient, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    return read_until(api, RULES, holds)


def told(service: Service, type_: str) -> list[dict[str, Any]]:
    return [row.data for row in service.events.since(0) if row.type == type_]


def test_rules_are_delivered_until_the_robot_follows_them(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    mind = deliberate(team)
    before = api.get(RULES)
    assert (before.headers["etag"], before.json()["delivery"]) == ('"0"', "untouched")
    team.faults.lost = 1
    files = {"sentry": GUARD.replace("guard", "sentry"), "guard": GUARD}
    answer = put(api, files, **{"if-match": '"0"'})
    assert (answer.status_code, answer.headers["etag"]) == (200, '"1"')
    ruled = until(api, lambda rules: rules["delivery"] == "acknowledged")
    assert [agent.name for agent in mind.agents] == ["sentry", "guard"]
    assert ruled["files"] == files
    assert ruled["followed"] == ruled["digests"] == dict(mind.digests)
    assert (ruled["comment"], ruled["decided_by"]) == ("at night", "administrator")
    (event,) = told(service, "rules.set")
    assert (event["version"], event["digests"]) == (1, ruled["digests"])
    assert [one["followed"] for one in told(service, "rules.acknowledged")] == [ruled["digests"]]


def test_rules_that_the_robot_refuses_leave_the_former_in_use_and_say_why(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    mind = deliberate(team, sensors=ALL_SENSORS - {Sensor.BUMPER})
    put(api, {"guard": GUARD})
    until(api, lambda rules: rules["delivery"] == "acknowledged")
    put(api, {"alert": ALERT})
    refused = until(api, lambda rules: rules["delivery"] == "refused")
    assert refused["detail"] == "yard_1 has no bumper, which rules alert need"
    assert refused["followed"] == {"guard": digest_of(GUARD)} == dict(mind.digests)
    assert [one["reason"] for one in told(service, "rules.refused")] == [refused["detail"]]


def test_software_that_does_not_know_rules_is_said_to_refuse_them(api: TestClient, team: FakeTeam) -> None:
    put(api, {"guard": GUARD})
    refused = until(api, lambda rules: rules["delivery"] == "refused")
    assert refused["detail"] == "not understood: unknown kind rule_set"


FAULTY = (
    ({"guard": "AGENT guard;\nBELIEF(start) =>"}, "guard:2:17: the end of the file cannot stand here"),
    (
        {"guard": GUARD.replace("adoptBelief(on_duty)", "activate(WANDR())")},
        "unknown packet WANDR; did you mean WANDER?",
    ),
    ({"sentry": GUARD}, "sentry:1:1: the file says that it is guard"),
    ({"guard": "ROLE guard;"}, "guard: a role needs the file of an agent beside it"),
    ({f"g{number}": "" for number in range(17)}, "at most 16 items"),
)


def test_faulty_rules_are_refused_by_file_line_and_column_before_they_are_sent(api: TestClient) -> None:
    for files, names in FAULTY:
        answer = put(api, files)
        assert answer.status_code == 422
        assert names in answer.json()["detail"]
    assert api.get(RULES).json()["version"] == 0


def test_rules_of_the_world_file_are_those_of_a_robot_that_was_sent_none(api: TestClient) -> None:
    robot = {"name": "yard_9", "compartment": "yard", "start": [4, 2.4, 0], "rules": {"guard": GUARD}}
    edit = {"edit": "add_robot", "robot": robot}
    assert (
        api.post("/v1/worlds/sample_store/changes", json={"reason": "more", "edits": [edit]}).status_code
        < 300
    )
    ruled = api.get("/v1/robots/yard_9/rules").json()
    assert (ruled["version"], ruled["delivery"], ruled["files"]) == (0, "untouched", {"guard": GUARD})
    assert ruled["digests"] == {"guard": digest_of(GUARD)}


def test_rules_from_an_outdated_version_are_refused(api: TestClient) -> None:
    assert put(api, {"guard": GUARD}).status_code == 200
    late = put(api, {}, **{"if-match": '"0"'})
    assert (late.status_code, late.json()["type"]) == (412, "urn:macta:problem:rules-changed")
    assert list(api.get(RULES).json()["files"]) == ["guard"]


@ON_POSTGRESQL
def test_the_first_rules_and_tunings_that_are_put_at_once_are_all_recorded(api: TestClient) -> None:
    for what, body in (("rules", {"files": {"guard": GUARD}}), ("tuning", {"tuning": {}})):
        for robot in ("yard_1", "yard_2", "store_1", "store_2"):
            path = f"/v1/robots/{robot}/{what}"
            with ThreadPoolExecutor(6) as clients:
                answers = [clients.submit(api.put, path, json=body) for _ in range(6)]
            versions = sorted(one.result().json().get("version", 0) for one in answers)
            assert versions == [1, 2, 3, 4, 5, 6]


def test_rules_need_permission_and_a_known_robot(api: TestClient) -> None:
    assert api.put("/v1/robots/nobody/rules", json={"files": {}}).status_code == 404
    api.headers.pop("authorization")
    assert put(api, {"guard": GUARD}).status_code == 401


MIND = "/v1/robots/yard_1/mind"


def test_a_robots_mind_is_what_the_robot_tells(api: TestClient, team: FakeTeam, patient: None) -> None:
    mind = deliberate(team)
    put(api, {"guard": GUARD})
    until(api, lambda rules: rules["delivery"] == "acknowledged")
    mind.agents[0].adopt([Term("on_duty")], 2.0)
    answer = api.get(MIND)
    assert answer.status_code == 200
    told = answer.json()
    assert (told["version"], told["digests"]) == (1, dict(mind.digests))
    (guard,) = told["agents"]
    assert ("on_duty", True, "adopted", 2.0) in [
        (one["term"], one["value"], one["origin"], one["since_s"]) for one in guard["beliefs"]
    ]


def test_a_robot_of_older_software_does_not_tell_its_mind(api: TestClient, patient: None) -> None:
    answer = api.get(MIND)
    assert (answer.status_code, answer.json()["type"]) == (409, "urn:macta:problem:no-mind")
    assert answer.json()["detail"].startswith("yard_1 does not tell of its mind")


def test_a_silent_robots_mind_is_not_known(api: TestClient, team: FakeTeam) -> None:
    team.faults.silent.add("yard_1")
    answer = api.get(MIND)
    assert (answer.status_code, answer.json()["type"]) == (504, "urn:macta:problem:robot-silent")
