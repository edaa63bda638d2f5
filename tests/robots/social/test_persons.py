"""A whole robot does what a person asks of it, tells how it ended, and answers questions."""

import pytest

from robots.executive.hand_over import MindDocument
from robots.physical.body import Pose
from robots.repertoire import load_self_level
from robots.social import SocialLevel, Term, parse_term
from robots.social.persons import _newest_beliefs, perform_of
from robots.social.protocols import OPENED_BY
from robots.wire import (
    MAX_CONTENT,
    SAID,
    BehaviourPacket,
    Message,
    MindOrder,
    MindVerb,
    Performative,
    Program,
    ScriptState,
    SpeechAct,
)
from tests.robots.fake_world import FakeWorld
from tests.robots.stories import NORTH, Service, packet, room, run, script

START = Pose(x_m=1.0, y_m=1.5, heading_rad=NORTH)
TURN = BehaviourPacket(
    id="1",
    tag="TURN_LEFT",
    arguments={},
    expected_start_s=0,
    expected_duration_s=30,
    timeout_s=30,
    wait_timeout_s=30,
)
DRIVE = packet("NAVIGATE", ref1="door", ref2="yard")


def fred_of(world: FakeWorld) -> Service:
    society = SocialLevel("fred", world.clock)
    return Service(world, world.add("fred", START, ["ginger"], society=society), "fred")


def say(
    service: Service,
    performative: Performative,
    content: Term,
    *,
    speaker: str = "ann",
    about: str = "c1",
    reply_by_s: float | None = None,
    **slots: str,
) -> Message:
    act = SpeechAct(
        content=str(content),
        protocol=OPENED_BY[performative].name if performative in OPENED_BY else "fipa-request",
        conversation_id=about,
        reply_by_s=reply_by_s,
        speaker=speaker,
    )
    return service.send(act, performative, **slots)


def ask(
    service: Service, content: str, performative: Performative = Performative.QUERY_REF, **slots: str
) -> list[str]:
    """What the robot answers until nothing more comes."""
    before = len(answers(service))
    say(service, performative, parse_term(content), **slots)
    run(service.world, [service], lambda: False, limit_s=2.0)
    return answers(service)[before:]


def answers(service: Service) -> list[str]:
    said = [one for one in service.heard if isinstance(one.body, SpeechAct)]
    return [f"{one.performative} {one.body.content}" for one in said if isinstance(one.body, SpeechAct)]


def request(service: Service, *packets: BehaviourPacket, name: str = "d1") -> None:
    say(service, Performative.REQUEST, perform_of(name, packets), about=name)


def ends(service: Service, count: int, limit_s: float = 60.0) -> list[str]:
    run(service.world, [service], lambda: len(answers(service)) >= count, limit_s=limit_s)
    return answers(service)


def test_a_robot_agrees_does_what_it_is_asked_and_says_so() -> None:
    service = fred_of(room())
    request(service, TURN, DRIVE)
    assert ends(service, 2) == ["agree agreed(d1)", "inform done(d1)"]
    assert [(one.tag, str(one.state)) for one in service.upkeep] == [
        ("TURN_LEFT", "running"),
        ("TURN_LEFT", "finished"),
        ("NAVIGATE", "running"),
        ("NAVIGATE", "finished"),
    ]


def test_another_robot_or_the_service_itself_cannot_ask_for_that() -> None:
    service = fred_of(room())
    say(service, Performative.REQUEST, perform_of("d1", [TURN]), speaker="")
    (answer,) = ends(service, 1, limit_s=3.0)
    assert answer.startswith("not-understood")
    assert service.upkeep == []


def test_a_robot_on_a_mission_refuses_and_goes_on_with_it() -> None:
    service = fred_of(room())
    service.order(script("fred", DRIVE, name="s1"))
    run(service.world, [service], lambda: False, limit_s=1.0)
    request(service, TURN)
    assert ends(service, 1, limit_s=3.0) == ['refuse refused("fred is busy with script s1")']
    assert run(service.world, [service], lambda: service.report is not None)
    assert service.report is not None
    assert service.report.state == "finished"


def test_a_missions_script_ends_what_a_person_has_asked_for() -> None:
    service = fred_of(room())
    request(service, DRIVE)
    ends(service, 1)
    service.order(script("fred", DRIVE, name="s1"))
    assert ends(service, 2, limit_s=3.0)[1] == 'failure failed(d1, "the robot took up script s1")'
    assert run(service.world, [service], lambda: service.report is not None)


def test_what_the_robot_cannot_do_is_refused_with_the_reason() -> None:
    service = fred_of(room())
    request(service, packet("NAVIGATE", ref1="door", ref2="moon"))
    (answer,) = ends(service, 1, limit_s=3.0)
    assert "moon is not a place that fred knows" in answer


def test_halt_ends_it_and_a_robot_that_stands_says_so() -> None:
    service = fred_of(room())
    request(service, DRIVE)
    ends(service, 1)
    assert ask(service, "halt", Performative.REQUEST, about="c2") == [
        "inform halted",
        "failure failed(d1, withdrawn)",
    ]
    assert ask(service, "halt", Performative.REQUEST, about="c3") == [
        'refuse refused("fred stands: nobody has asked for that")'
    ]


def test_a_halt_that_names_a_script_spares_the_next_one() -> None:
    service = fred_of(room())
    request(service, DRIVE)
    ends(service, 1)
    assert ask(service, "halt(d1)", Performative.REQUEST, about="c2") == [
        "inform halted",
        "failure failed(d1, withdrawn)",
    ]
    request(service, DRIVE, name="d2")
    ends(service, 4)
    assert ask(service, "halt(d1)", Performative.REQUEST, about="c3") == [
        'refuse refused("fred is not at d1")'
    ]
    assert service.upkeep[-1].state == "running"


def test_a_request_that_arrives_after_its_halt_is_refused() -> None:
    service = fred_of(room())
    ask(service, "halt(d1)", Performative.REQUEST, about="c2")
    request(service, DRIVE)
    assert ends(service, 2, limit_s=3.0)[1] == 'refuse refused("it was withdrawn")'
    assert service.upkeep == []


def test_a_cancelled_request_ends_the_script() -> None:
    service = fred_of(room())
    request(service, DRIVE)
    ends(service, 1)
    say(service, Performative.CANCEL, Term("d1"), about="d1")
    run(service.world, [service], lambda: False, limit_s=1.0)
    assert service.telemetry[-1].script_state == "cancelled"


def test_what_a_person_no_longer_waits_for_ends() -> None:
    service = fred_of(room())
    say(service, Performative.REQUEST, perform_of("d1", [DRIVE]), about="d1", reply_by_s=3.0)
    assert ends(service, 1) == ["agree agreed(d1)"]
    run(service.world, [service], lambda: False, limit_s=1.0)
    assert service.world.agents["fred"].state_of(f"{SAID}d1") is ScriptState.RUNNING
    run(service.world, [service], lambda: False, limit_s=3.0)
    assert service.world.agents["fred"].state_of(f"{SAID}d1") is ScriptState.CANCELLED


@pytest.mark.parametrize("ends_by", [Performative.CANCEL, Performative.NOT_UNDERSTOOD])
def test_a_question_that_was_withdrawn_while_the_robot_looks_is_not_answered(ends_by: Performative) -> None:
    service = fred_of(room())
    act = say(service, Performative.QUERY_REF, Term("seen"))
    service.send(act.body, ends_by)
    run(service.world, [service], lambda: False, limit_s=8.0)
    assert answers(service) == ["agree seen"]


def test_a_question_whose_answer_is_too_long_fails() -> None:
    service = fred_of(room())
    say(service, Performative.QUERY_REF, Term("place", ("ä" * 600,)))
    act = SpeechAct(
        content=f'place("{"ä" * 700}")', protocol="fipa-query", conversation_id="c2", speaker="ann"
    )
    service.send(act, Performative.QUERY_REF)
    run(service.world, [service], lambda: False, limit_s=8.0)
    told = [answer.split("(")[0] for answer in answers(service)]
    assert sorted(told) == ["agree place", "agree too_long", "failure too_long", "inform not"]


def test_a_repeated_request_is_done_once_also_after_a_power_failure() -> None:
    world = room()
    service = fred_of(world)
    act = say(service, Performative.REQUEST, perform_of("d1", [TURN]))
    ends(service, 2)
    service.link.send(act)
    assert ends(service, 3)[2] == "inform done(d1)"
    assert [one.tag for one in service.upkeep].count("TURN_LEFT") == 2


def test_what_a_person_has_asked_for_goes_on_in_another_program() -> None:
    world = room()
    service = fred_of(world)
    request(service, TURN, DRIVE)
    ends(service, 1)
    before = world.agents["fred"]
    text = before.hand_over().model_dump_json()
    world.take_over("fred", MindDocument.model_validate_json(text), SocialLevel("fred", world.clock))
    order = MindOrder(verb=MindVerb.GO_ON, fence=1, to=Program.OWN)
    service.send(order, Performative.REQUEST)
    assert ends(service, 2) == ["agree agreed(d1)", "inform done(d1)"]
    finished = [one.tag for one in service.upkeep if one.state == "finished"]
    assert finished == ["TURN_LEFT", "NAVIGATE"]


@pytest.mark.parametrize(
    ("question", "performative", "answer"),
    [
        ("battery", Performative.QUERY_REF, "inform battery(1)"),
        ("activity", Performative.QUERY_REF, "inform activity(nothing)"),
        ("beliefs", Performative.QUERY_REF, "inform beliefs"),
        ("held", Performative.QUERY_REF, "inform held(nothing)"),
        ("holds(s9)", Performative.QUERY_IF, "inform not(holds(s9))"),
        ("place(s9)", Performative.QUERY_REF, "inform not(seen(s9))"),
    ],
)
def test_a_question_is_answered_by_what_the_robot_knows(
    question: str, performative: Performative, answer: str
) -> None:
    service = fred_of(room())
    run(service.world, [service], lambda: False, limit_s=1.0)
    assert ask(service, question, performative)[-1] == answer


def test_the_robot_looks_before_it_says_what_it_sees_and_says_where_it_is() -> None:
    service = fred_of(room())
    run(service.world, [service], lambda: False, limit_s=3.0)
    agreed, seen = ask(service, "seen")
    assert agreed == "agree seen"
    assert "door" in parse_term(seen.removeprefix("inform ")).words
    (at,) = ask(service, "position", about="c2")
    x_m = parse_term(at.removeprefix("inform ")).args[0]
    assert isinstance(x_m, Term)
    assert x_m.args[0] == pytest.approx(1.0, abs=0.1)


def test_of_beliefs_that_are_too_long_for_one_message_the_newest_are_told() -> None:
    beliefs = [f"{number}{'ä' * 190}" for number in range(64)]
    content = _newest_beliefs(beliefs)
    assert len(str(content)) <= MAX_CONTENT
    assert content.args == tuple(beliefs[-len(content.args) :])


def test_what_a_person_has_asked_for_stops_at_a_critical_battery() -> None:
    service = fred_of(room())
    request(service, DRIVE)
    assert ends(service, 1) == ["agree agreed(d1)"]
    service.world.bodies["fred"].battery = load_self_level().critical - 0.01
    _, end = ends(service, 2)
    assert end.startswith("failure failed(d1")
    assert "broke off: battery at" in end
