"""A person speaks to one robot: clarification, approval, refusal, and what the robot answers."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.agents.running_world import FLAT_OUT
from app.composition import Service
from app.missions.dialogues import ANSWER_S, AWARD_S
from app.store import DialogueRow
from robots.wire import Performative
from tests.app.fake_robots import FakeRobot, FakeTeam
from tests.databases import ON_POSTGRESQL
from tests.waiting import in_state, mission_of, read_until, until

WORDS = "/v1/robots/yard_2/dialogues"
AGREED = (Performative.AGREE, "agreed(x)")
DONE = (Performative.INFORM, "done(x)")
FACE = "face sample_1"


def robot_of(team: FakeTeam, name: str = "yard_2") -> FakeRobot:
    """A robot that is in contact; it has sent telemetry."""
    team.tell(name, battery=1.0)
    return team.robots.setdefault(name, FakeRobot())


def say(api: TestClient, text: str, **more: Any) -> Any:
    return api.post(WORDS, json={"text": text, **more})


def code(response: Any) -> str:
    return str(response.json()["type"].rpartition(":")[2])


def known(api: TestClient, team: FakeTeam) -> FakeRobot:
    robot = robot_of(team)
    read_until(api, "/v1/robots/yard_2", lambda one: one["connection"] == "online")
    return robot


def told(service: Service) -> list[tuple[str, str]]:
    return [
        (row.type, row.data["words"]) for row in service.events.since(0) if row.type.startswith("dialogue.")
    ]


def test_a_script_is_shown_approved_done_and_told(api: TestClient, team: FakeTeam, service: Service) -> None:
    robot = known(api, team)
    robot.says["perform"] = [AGREED, DONE]
    answer = say(api, FACE)
    assert answer.status_code == 202, answer.text
    shown = answer.json()
    assert (shown["state"], shown["reason"], robot.heard) == ("proposed", "", [])
    (packet,) = shown["script"]
    assert (packet["tag"], packet["arguments"]) == ("FACE_OBJECT", {"object": "sample_1"})
    path = f"{WORDS}/{shown['id']}"
    assert api.get("/v1/robots/yard_2").json()["dialogue_id"] == shown["id"]
    assert api.post(f"{path}:approve").json()["state"] == "said"
    done = in_state(api, path, "done")
    assert [(one["by"], one["performative"]) for one in done["lines"]] == [
        ("administrator", "request"),
        ("yard_2", "propose"),
        ("administrator", "accept-proposal"),
        ("yard_2", "agree"),
        ("yard_2", "inform"),
    ]
    ((performative, content, speaker),) = robot.heard
    assert (performative, speaker) == ("request", "administrator")
    assert (
        content == f"perform({shown['id']}, packet(FACE_OBJECT, {packet['timeout_s']:g}, object(sample_1)))"
    )
    assert told(service)[-1] == ("dialogue.done", "done")
    assert api.get("/v1/robots/yard_2").json()["dialogue_id"] is None
    assert code(api.post(f"{path}:approve")) == "not-proposed"


def test_which_one_is_asked_and_the_next_word_completes_it(api: TestClient, team: FakeTeam) -> None:
    robot = known(api, team)
    robot.says["perform"] = [AGREED]
    asked = say(api, "REQUEST target:yard_2 action:face").json()
    assert asked["state"] == "asking"
    assert "sample_1" in asked["question"]["choices"]
    refused = say(api, "sample 99", dialogue=asked["id"])
    assert refused.status_code == 422
    answered = say(api, "sample 1", dialogue=asked["id"], approve=True).json()
    assert answered["text"] == "REQUEST target:yard_2 action:face object:sample_1"
    assert in_state(api, f"{WORDS}/{asked['id']}", "agreed")["script"][0]["tag"] == "FACE_OBJECT"


def test_what_is_not_understood_names_the_word_and_is_not_recorded(api: TestClient, team: FakeTeam) -> None:
    known(api, team)
    refused = say(api, "fase sample_1")
    problem = refused.json()
    assert (code(refused), problem["thing"], problem["span"]) == ("words-not-understood", "fase", [0, 4])
    assert problem["choices"][0] == "face"
    assert api.get(WORDS).json()["items"] == []


def test_a_script_stated_as_content_and_what_no_message_holds_reach_no_robot(
    api: TestClient, team: FakeTeam
) -> None:
    robot = known(api, team)
    robot.says["battery"] = [(Performative.INFORM, "battery(0.83)")]
    past_approval = say(api, 'REQUEST content:"perform(x, packet(NAVIGATE, 600, ref1(door_1)))"')
    assert (past_approval.status_code, code(past_approval)) == (422, "words-not-understood")
    too_long = say(api, "INFORM action:" + "\U0001f600" * 400)
    assert (too_long.status_code, code(too_long)) == (422, "too-long-to-say")
    assert api.get(WORDS).json()["items"] == []
    asked = say(api, "how is your battery?").json()
    in_state(api, f"{WORDS}/{asked['id']}", "done")
    assert [one[:2] for one in robot.heard] == [("query-ref", "battery")]


def test_a_question_is_answered_by_the_robot(api: TestClient, team: FakeTeam) -> None:
    robot = known(api, team)
    robot.says["battery"] = [(Performative.INFORM, "battery(0.83, charging)")]
    asked = say(api, "how is your battery?").json()
    done = in_state(api, f"{WORDS}/{asked['id']}", "done")
    assert done["lines"][-1]["words"] == "my battery is at 83%, and I charge"
    assert robot.heard == [("query-ref", "battery", "administrator")]


def test_any_performative_reaches_the_robot_and_an_answer_goes_on_with_it(
    api: TestClient, team: FakeTeam
) -> None:
    robot = known(api, team)
    robot.says["leg"] = [(Performative.PROPOSE, "bid(1)")]
    robot.says["award"] = [DONE]
    called = say(api, "CFP content:leg(1)").json()
    path = f"{WORDS}/{called['id']}"
    read_until(api, path, lambda one: one["lines"][-1]["performative"] == "propose")
    say(api, "ACCEPT-PROPOSAL content:award(1)", dialogue=called["id"])
    in_state(api, path, "done")
    assert [one[:2] for one in robot.heard] == [("cfp", "leg(1)"), ("accept-proposal", "award(1)")]


def test_a_rejected_bid_ends_the_dialogue(api: TestClient, team: FakeTeam) -> None:
    robot = known(api, team)
    robot.says["leg"] = [(Performative.PROPOSE, "bid(1)")]
    called = say(api, "CFP content:leg(1)").json()
    read_until(api, f"{WORDS}/{called['id']}", lambda one: one["lines"][-1]["performative"] == "propose")
    ended = say(api, "REJECT-PROPOSAL content:reject(1)", dialogue=called["id"]).json()
    assert (ended["state"], ended["reason"]) == ("withdrawn", "its bid was not taken")


@pytest.mark.parametrize(
    ("answer", "state", "reason"),
    [
        ((Performative.REFUSE, 'refused("low")'), "refused", "no: low"),
        ((Performative.FAILURE, 'failed(x, "stuck")'), "failed", "I could not: stuck"),
        ((Performative.NOT_UNDERSTOOD, 'reason("what")'), "not_understood", "I do not understand: what"),
    ],
)
def test_what_the_robot_does_not_do_has_its_reason(
    answer: tuple[Performative, str], state: str, reason: str, api: TestClient, team: FakeTeam
) -> None:
    known(api, team).says["perform"] = [answer]
    said = say(api, FACE, approve=True).json()
    ended = in_state(api, f"{WORDS}/{said['id']}", state)
    assert ended["reason"] == reason


def test_a_robot_that_does_not_answer_has_timed_out(api: TestClient, team: FakeTeam) -> None:
    known(api, team)
    said = say(api, "where are you?").json()
    team.clock.advance(FLAT_OUT * ANSWER_S)
    ended = in_state(api, f"{WORDS}/{said['id']}", "timed_out")
    assert "has not answered in time" in ended["reason"]


def test_the_same_key_says_it_once(api: TestClient, team: FakeTeam) -> None:
    robot = known(api, team)
    robot.says["perform"] = [AGREED]
    headers = {"idempotency-key": "once"}
    first, second = (
        api.post(WORDS, json={"text": FACE, "approve": True}, headers=headers).json() for _ in range(2)
    )
    assert first["id"] == second["id"]
    reused = api.post(WORDS, json={"text": "turn left"}, headers=headers)
    assert (reused.status_code, code(reused)) == (409, "idempotency-key-reused")


def test_the_same_key_answers_a_question_once(api: TestClient, team: FakeTeam) -> None:
    known(api, team)
    asked = say(api, "REQUEST target:yard_2 action:face").json()
    answer = {"text": "sample 1", "dialogue": asked["id"]}
    headers = {"idempotency-key": "answer"}
    first, second = (api.post(WORDS, json=answer, headers=headers).json() for _ in range(2))
    assert (first["state"], first) == ("proposed", second)
    other = api.post(WORDS, json={**answer, "text": "sample 2"}, headers=headers)
    assert (other.status_code, code(other)) == (409, "idempotency-key-reused")


@ON_POSTGRESQL
def test_equal_words_at_once_are_one_dialogue(api: TestClient, team: FakeTeam) -> None:
    known(api, team)
    headers = {"idempotency-key": "at once"}
    with ThreadPoolExecutor(4) as clients:
        said = [clients.submit(api.post, WORDS, json={"text": FACE}, headers=headers) for _ in range(4)]
    answers = [one.result() for one in said]
    assert [one.status_code for one in answers] == [202] * 4
    assert len({one.json()["id"] for one in answers}) == 1


def test_a_script_that_nobody_approves_gives_way_to_later_words(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    known(api, team)
    shown = [say(api, FACE).json()["id"] for _ in range(2)]
    with service.database.write() as session:
        row = session.get_one(DialogueRow, shown[0])
        row.lines = [{**one, "at": "2020-01-01T00:00:00.000Z"} for one in row.lines]
    say(api, "turn left")
    states = [api.get(f"{WORDS}/{one}").json()["state"] for one in shown]
    assert states == ["withdrawn", "proposed"]


def test_bids_wait_for_a_person_to_decide_and_an_award_for_its_end(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    robot = known(api, team)
    robot.says["leg"] = [(Performative.PROPOSE, "bid(1)")]
    called = say(api, "CFP content:leg(1)").json()
    path = f"{WORDS}/{called['id']}"
    read_until(api, path, lambda one: one["lines"][-1]["performative"] == "propose")
    team.clock.advance(ANSWER_S + 30)
    say(api, "ACCEPT-PROPOSAL content:award(1)", dialogue=called["id"])
    team.clock.advance(AWARD_S + FLAT_OUT * ANSWER_S + 30)
    assert in_state(api, path, "timed_out")["lines"][-1]["performative"] == "accept-proposal"


@pytest.mark.parametrize("words", [None, "CANCEL content:perform"])
def test_a_withdrawn_request_halts_the_robot(words: str | None, api: TestClient, team: FakeTeam) -> None:
    robot = known(api, team)
    robot.says["perform"] = [AGREED]
    robot.says["halt"] = [(Performative.INFORM, "halted")]
    said = say(api, FACE, approve=True).json()
    path = f"{WORDS}/{said['id']}"
    in_state(api, path, "agreed")
    busy = say(api, "turn left").json()
    assert (busy["state"], busy["reason"]) == (
        "refused",
        "yard_2 is at 'face sample_1', as administrator has asked; say stop first",
    )
    if words is None:
        withdrawn = api.post(f"{path}:withdraw")
    else:
        withdrawn = say(api, words, dialogue=said["id"])
    assert withdrawn.json()["state"] == "withdrawn"
    read_until(api, path, lambda one: one["lines"][-1]["words"] == "I have stopped")
    assert robot.heard[-1][:2] == ("request", f"halt({said['id']})")


def test_a_withdrawal_that_the_robot_does_not_answer_says_so(api: TestClient, team: FakeTeam) -> None:
    known(api, team).says["perform"] = [AGREED]
    path = f"{WORDS}/{say(api, FACE, approve=True).json()['id']}"
    in_state(api, path, "agreed")
    api.post(f"{path}:withdraw", json={"comment": "too far"})
    team.clock.advance(FLAT_OUT * ANSWER_S)
    unheard = "too far; yard_2 has not answered the order to stop, and may still be at it"
    assert read_until(api, path, lambda one: one["reason"] == unheard)["state"] == "withdrawn"


def test_nothing_new_is_asked_for_until_stop_is_answered(api: TestClient, team: FakeTeam) -> None:
    robot = known(api, team)
    stopped = say(api, "stop").json()
    assert say(api, FACE).json()["reason"] == "yard_2 has not answered stop yet; say it again then"
    robot.says["halt"] = [(Performative.REFUSE, 'refused("yard_2 stands")')]
    in_state(api, f"{WORDS}/{stopped['id']}", "refused")
    assert say(api, FACE).json()["state"] == "proposed"


def test_a_robot_on_a_mission_refuses_and_stop_pauses_the_mission(
    api: TestClient, team: FakeTeam, service: Service
) -> None:
    robot = known(api, team)
    team.faults.takes_s["NAVIGATE"] = 1e6
    goal = {"text": "send yard_2 to door_2", "auto_approve": True}
    stated = api.post("/v1/goals", json=goal).json()
    mission = mission_of(api, stated["id"])
    read_until(api, "/v1/robots/yard_2", lambda one: one["mission_id"] == mission)
    refused = say(api, FACE, approve=True).json()
    assert refused["reason"].startswith(f"yard_2 is on mission {mission}")
    stopped = say(api, "stop").json()
    assert (stopped["state"], mission in stopped["lines"][-1]["words"]) == ("done", True)
    assert [one for one in robot.heard if "halt" in one[1]] == []
    assert [row.data["comment"] for row in service.events.since(0) if row.type == "mission.paused"] == [
        "yard_2 was told to stop"
    ]


def test_what_a_mission_needs_and_what_is_kept_empty_is_left_alone(api: TestClient, team: FakeTeam) -> None:
    known(api, team)
    team.faults.takes_s["NAVIGATE"] = 1e6
    goal = {"text": "send yard_1 to door_2", "auto_approve": True}
    stated = api.post("/v1/goals", json=goal).json()
    mission = mission_of(api, stated["id"])
    read_until(api, "/v1/robots/yard_1", lambda one: one["mission_id"] == mission)
    known(api, team)  # the world's time goes on meanwhile
    assert say(api, "go to door_2").json()["reason"] == f"mission {mission} needs door_2"
    api.post("/v1/goals", json={"text": "keep interchange_1 empty until further notice"})
    read_until(api, "/v1/worlds/sample_store/holds", lambda one: one["items"])
    known(api, team)
    put = "take sample_1, carry it to interchange_1, put down it at interchange_1"
    assert say(api, put).json()["reason"].startswith("interchange_1 is kept empty")
    assert say(api, "go to interchange_1").json()["state"] == "proposed"


def test_a_robot_and_a_sample_that_are_kept_where_they_are_are_left_alone(
    api: TestClient, team: FakeTeam
) -> None:
    known(api, team)
    api.post("/v1/goals", json={"text": "keep sample_1 in door_1 until further notice"})
    read_until(api, "/v1/worlds/sample_store/holds", lambda one: one["items"])
    known(api, team)
    put = "take sample_1, carry it to interchange_1, put down it at interchange_1"
    assert say(api, put).json()["reason"].startswith("sample_1 is kept where it is: sample_1 in door_1")
    api.post("/v1/goals", json={"text": "keep yard_2 at home_yard_2 until further notice"})
    read_until(api, "/v1/worlds/sample_store/holds", lambda one: len(one["items"]) == 2)
    known(api, team)
    assert say(api, "go to door_2").json()["reason"].startswith("yard_2 is kept where it is")


def test_a_driven_robot_refuses(api: TestClient, team: FakeTeam) -> None:
    known(api, team)
    team.tell("yard_2", battery=1.0, driven_by="ada")
    refused = read_until_said(api)
    assert refused["reason"] == "ada drives yard_2"


def read_until_said(api: TestClient) -> dict[str, Any]:
    """What is answered once the telemetry has arrived."""
    answers: list[dict[str, Any]] = []

    def is_refused() -> bool:
        answers.append(say(api, FACE).json())
        return bool(answers[-1]["state"] == "refused")

    until(is_refused)
    return answers[-1]


def test_no_is_a_withdrawal_and_yes_an_approval(api: TestClient, team: FakeTeam) -> None:
    known(api, team).says["perform"] = [AGREED]
    shown = say(api, FACE).json()
    assert say(api, "No.", dialogue=shown["id"]).json()["state"] == "withdrawn"
    assert code(say(api, "yes", dialogue=shown["id"])) == "dialogue-ended"
    again = say(api, FACE).json()
    assert say(api, "yes", dialogue=again["id"]).json()["state"] == "said"


def test_a_robot_out_of_service_or_out_of_contact_refuses(api: TestClient, team: FakeTeam) -> None:
    assert say(api, FACE).json()["reason"].startswith("yard_2 is not in contact")
    known(api, team)
    api.post("/v1/robots/yard_2:take_out_of_service", json={"reason": "its wheel slips"})
    assert say(api, FACE).json()["reason"] == "yard_2 is out of service: its wheel slips"
