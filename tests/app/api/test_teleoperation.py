"""An operator drives a robot over the API, if nothing stands against it."""

from typing import Any

from fastapi.testclient import TestClient
from httpx2 import Response

from app.composition import Service
from robots.wire import PacketState, SymbolicFact, UpkeepReport
from tests.app.fake_robots import FakeTeam
from tests.waiting import read_until, until

YARD = "/v1/robots/yard_1"
ADA = "administrator (ada)"


def drive(api: TestClient, session: str = "ada", **wish: float) -> Response:
    answer: Response = api.post(f"{YARD}:teleoperate", json={"session": session, **wish})
    return answer


def heard(api: TestClient, team: FakeTeam) -> None:
    team.tell("yard_1", battery=1.0)
    read_until(api, YARD, lambda robot: robot["connection"] == "online")


def refused(answer: Response) -> tuple[str, str]:
    assert answer.status_code == 409
    body = answer.json()
    return body["type"].rpartition(":")[2], body["detail"]


def events(service: Service) -> list[tuple[str, dict[str, Any]]]:
    return [(row.type, row.data) for row in service.events.since(0) if row.type.startswith("teleoperation")]


def test_set_points_reach_the_robot_and_letting_go_does(api: TestClient, team: FakeTeam) -> None:
    heard(api, team)
    told = drive(api, speed_m_s=0.2, turn_rad_s=-0.5)
    assert told.status_code == 202
    assert {"robot": "yard_1", "driver": ADA, "most_m_s": 0.3, "valid_s": 5.0}.items() <= told.json().items()
    read_until(api, YARD, lambda robot: robot["driven_by"] == ADA)
    assert drive(api).json()["driving"]
    api.post(f"{YARD}:end_teleoperation", json={"session": "ada"})
    read_until(api, YARD, lambda robot: robot["driven_by"] is None)
    first, *_, last = team.robots["yard_1"].set_points
    assert (first.driver, first.speed_m_s, first.turn_rad_s, first.ends) == (ADA, 0.2, -0.5, False)
    assert last.ends
    assert last.number > first.number


def test_a_second_operator_is_refused_with_the_name_of_the_first(api: TestClient, team: FakeTeam) -> None:
    heard(api, team)
    assert drive(api).status_code == 202
    assert refused(drive(api, "bob")) == ("driven-by-another", f"{ADA} drives yard_1")
    api.post(f"{YARD}:end_teleoperation", json={"session": "bob"})
    assert drive(api).status_code == 202, "another cannot release it for them"
    api.post(f"{YARD}:end_teleoperation", json={"session": "ada"})
    assert drive(api, "bob").status_code == 202


def test_who_drives_it_through_another_process_has_it_too(api: TestClient, team: FakeTeam) -> None:
    team.tell("yard_1", battery=1.0, driven_by="administrator (eve)")
    read_until(api, YARD, lambda robot: robot["driven_by"] is not None)
    assert refused(drive(api)) == ("driven-by-another", "administrator (eve) drives yard_1")


def test_a_drive_goes_on_through_another_process_and_ends_there(api: TestClient, team: FakeTeam) -> None:
    team.tell("yard_1", battery=1.0, driven_by=ADA)
    read_until(api, YARD, lambda robot: robot["driven_by"] == ADA)
    api.post(f"{YARD}:end_teleoperation", json={"session": "ada"})
    read_until(api, YARD, lambda robot: robot["driven_by"] is None)
    assert [one.ends for one in team.robots["yard_1"].set_points] == [True]


def test_a_set_point_that_its_release_has_overtaken_is_refused(api: TestClient, team: FakeTeam) -> None:
    heard(api, team)
    assert drive(api).status_code == 202
    api.post(f"{YARD}:end_teleoperation", json={"session": "ada"})
    assert refused(drive(api, speed_m_s=0.2)) == (
        "session-over",
        f"{ADA} has released yard_1; take control with a new session",
    )
    until(lambda: "yard_1" in team.robots and any(one.ends for one in team.robots["yard_1"].set_points))
    assert not any(one.speed_m_s for one in team.robots["yard_1"].set_points)
    assert drive(api, "ada-again").status_code == 202


def test_a_robot_that_is_silent_lost_or_unwilling_is_not_driven(api: TestClient, team: FakeTeam) -> None:
    assert refused(drive(api)) == ("robot-out-of-contact", "yard_1 is not in contact: offline")
    heard(api, team)
    team.faults.refuses.add("yard_1")
    drive(api)
    until(lambda: drive(api).status_code == 409, "the refusal is never told")
    assert refused(drive(api)) == ("robot-refuses", "yard_1 is not willing")
    team.faults.refuses.clear()
    assert drive(api, "ada-again").status_code == 202
    api.post(f"{YARD}:declare_lost")
    assert refused(drive(api, "ada-again"))[0] == "robot-lost"


def test_a_robot_on_a_mission_is_not_driven(api: TestClient, team: FakeTeam, follow: Any) -> None:
    team.tick_s = 0.0  # no time goes by that the mission could fail in
    goal = api.post("/v1/goals", json={"text": "move sample_1 to bay_7", "auto_approve": True}).json()
    follow(f"/v1/goals/{goal['id']}", "committed")
    with_robots = read_until(api, "/v1/robots", lambda page: any(r["mission_id"] for r in page["items"]))
    busy = next(robot for robot in with_robots["items"] if robot["mission_id"])
    answer = api.post(f"/v1/robots/{busy['name']}:teleoperate", json={"session": "ada"})
    assert refused(answer) == ("on-mission", f"{busy['name']} is on mission {busy['mission_id']}")


def test_a_driven_robot_is_not_recruited_until_it_is_released(api: TestClient, team: FakeTeam) -> None:
    team.tell("store_2", battery=1.0, driven_by=ADA)
    read_until(api, "/v1/robots/store_2", lambda robot: robot["driven_by"] == ADA)
    goal = f"/v1/goals/{api.post('/v1/goals', json={'text': 'move sample_4 to bay_8'}).json()['id']}"
    waits = read_until(api, goal, lambda goal: goal["reason"])
    assert (waits["state"], waits["reason"]) == ("waiting", f"waits for store_2, which {ADA} drives")
    team.tell("store_2", battery=1.0)
    assert read_until(api, goal, lambda goal: goal["state"] == "planned")


def test_a_drive_is_on_record_and_where_it_ended_is_believed(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    def report(state: PacketState, at_s: float, *facts: SymbolicFact, detail: str = "") -> None:
        told = UpkeepReport(
            tag="TELEOPERATE", state=state, at_s=at_s, perceived=facts, detail=detail, driver=ADA
        )
        team.report("yard_1", told)

    def stands() -> list[str]:
        facts = api.get("/v1/worlds/sample_store/facts").json()["items"]
        return [f"{f['predicate']} {f['args'][1]}" for f in facts if f["args"][0] == "yard_1"]

    began_s = team.clock.now_s() + 1
    report(PacketState.RUNNING, began_s)
    until(lambda: "near yard_1_spot" in stands(), "it is on its way")
    report(PacketState.RUNNING, began_s + 1, detail="goes on though whisker 2 reads 1.90 wherever it looks")
    at_door = SymbolicFact(predicate="near", args=("yard_1", "door_2"))
    report(PacketState.FINISHED, began_s + 9, at_door)
    until(lambda: "near door_2" in stands(), "where it stands is never believed")
    assert "near yard_1_spot" not in stands()
    assert [(what, data["driver"], data["at_s"]) for what, data in events(service)] == [
        ("teleoperation.began", ADA, began_s),
        ("teleoperation.ended", ADA, began_s + 9),
    ]
