"""What a robot says changes only what is of its own actions and state: never another robot, a script that is not its
own, the layout, or an edition of the world.
"""

import itertools
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from app.agents.agent_models import Reception
from app.agents.questions import Questions
from app.domain.errors import Silent
from robots.wire import (
    Body,
    FailureCategory,
    Message,
    PacketReport,
    PacketState,
    Performative,
    SampleReport,
    ScriptReport,
    ScriptState,
    StatusReport,
    SymbolicFact,
    TraceReport,
    UpkeepReport,
)
from tests.app.missions.mission_services import WORLD
from tests.app.missions.test_plausibility import Mission
from tests.waiting import LONG_S, awaited

THIEF = "yard_1"
VICTIM = "store_2"
IDS = itertools.count()


@pytest.fixture
def mission(tmp_path: Path) -> Iterator[Mission]:
    mission = Mission(tmp_path)
    yield mission
    mission.services.close()


def say(mission: Mission, body: Body, *, sender: str = THIEF, message_id: str = "") -> Reception:
    message = Message(
        id=message_id or f"said-{next(IDS)}",
        performative=Performative.INFORM,
        sender=sender,
        receiver="service",
        sent_at_s=mission.clock.now_s(),
        body=body,
    )
    return mission.services.reports.record(message, WORLD)


def fact(text: str) -> SymbolicFact:
    predicate, _, args = text.removesuffix(")").partition("(")
    return SymbolicFact(predicate=predicate, args=tuple(args.split(", ")))


OF_OTHERS = [
    "near(store_2, bay_7)",
    "gripper(store_2, empty)",
    "in(sample_1, store_2)",
    "transported(sample_1, store_2, near, rack_1, near, bay_7)",
    "tracked(store_2, yard_1)",
    "holds_alone(store_2, sample_1)",
]
OF_THE_WORLD = [
    "reaches(yard_1, bay_7)",
    "can(yard_1, TRACK)",
    "can(store_2, DOCK)",
    "in_area(yard_1, store)",
]
OUT_OF_REACH = ["in(sample_1, bay_7)", "vacant(bay_7)", "vacant(bay_1)"]


AT_HOME = (fact("gripper(yard_1, empty)"), fact("near(yard_1, home_yard_1)"))
"""As the thief is believed to be."""


@pytest.mark.parametrize("told", [*OF_OTHERS, *OF_THE_WORLD, *OUT_OF_REACH])
def test_a_robot_that_fails_changes_no_fact_of_others_or_of_the_world(mission: Mission, told: str) -> None:
    before = mission.facts
    mission.clock.advance(60.0)
    failed = mission.end(THIEF, ScriptState.FAILED, perceived=(*AT_HOME, fact(told)))
    assert say(mission, failed) is Reception.RECORDED
    assert mission.facts == before


@pytest.mark.parametrize("told", [*OF_OTHERS, *OF_THE_WORLD, *OUT_OF_REACH])
def test_a_robot_on_its_own_errand_changes_no_fact_of_others_or_of_the_world(
    mission: Mission, told: str
) -> None:
    before = mission.facts
    mission.clock.advance(60.0)
    errand = UpkeepReport(
        tag="CHARGE", state=PacketState.FINISHED, at_s=mission.clock.now_s(), perceived=(*AT_HOME, fact(told))
    )
    assert say(mission, errand) is Reception.RECORDED
    assert mission.facts == before


def test_what_a_robot_sees_where_it_gets_to_is_believed(mission: Mission) -> None:
    mission.clock.advance(60.0)
    seen = fact("in(sample_1, interchange_1)")
    mission.tell(THIEF, "interchange_1")
    assert say(mission, mission.end(THIEF, ScriptState.FAILED, perceived=(seen,))) is Reception.RECORDED
    assert any(one.args == ("sample_1", "in", "interchange_1") for one in mission.facts)


@pytest.mark.parametrize("kind", ["packet", "script", "status"])
def test_a_report_on_another_robots_script_changes_nothing(mission: Mission, kind: str) -> None:
    mission.clock.advance(600.0)
    before = mission.facts
    script = mission.script(VICTIM)
    body: Body
    if kind == "packet":
        body = mission.packet(VICTIM, 0)
    elif kind == "script":
        body = mission.end(VICTIM)
    else:
        body = StatusReport(script_id=script.id, state=None, at_s=mission.clock.now_s())
    assert say(mission, body) is Reception.IGNORED
    assert mission.facts == before
    after = mission.script(VICTIM)
    assert (after.state, after.packets, after.detail) == (script.state, script.packets, script.detail)


def test_a_packet_of_another_robots_script_is_none_of_its_own(mission: Mission) -> None:
    mission.clock.advance(600.0)
    before = mission.facts
    stranger = PacketReport(
        script_id=mission.script(THIEF).id,
        packet_id=mission.packets(VICTIM)[-1],
        state=PacketState.FINISHED,
        at_s=mission.clock.now_s(),
    )
    say(mission, stranger)
    assert mission.facts == before
    assert not mission.script(THIEF).packets
    assert not mission.script(VICTIM).packets


def test_a_script_that_a_robot_invents_is_ignored(mission: Mission) -> None:
    before = mission.facts
    invented = ScriptReport(
        script_id="invented",
        state=ScriptState.FAILED,
        at_s=mission.clock.now_s(),
        category=FailureCategory.ROBOT,
        perceived=(fact("in(sample_1, interchange_1)"),),
    )
    assert say(mission, invented) is Reception.IGNORED
    assert mission.facts == before


def test_the_ids_of_one_robots_messages_are_not_anothers(mission: Mission) -> None:
    """Robots may number their messages; an impostor may guess the next number of another."""
    mission.clock.advance(60.0)
    upkeep = UpkeepReport(tag="CHARGE", state=PacketState.RUNNING, at_s=mission.clock.now_s())
    for robot in (THIEF, VICTIM):
        assert say(mission, upkeep, sender=robot, message_id="1") is Reception.RECORDED
        assert say(mission, upkeep, sender=robot, message_id="1") is Reception.IGNORED, "it was repeated"


@pytest.mark.parametrize(
    ("sample", "place"),
    [
        ("pebble", "bay_7"),  # yard_1 does not get there
        ("store_2", "interchange_1"),
        ("bay_7", "interchange_1"),
        ("No Name", "interchange_1"),
        ("pebble", "nowhere"),
    ],
)
def test_no_sample_is_added_that_the_robot_cannot_have_seen(
    mission: Mission, sample: str, place: str
) -> None:
    before = mission.facts
    seen = SampleReport(sample=sample, place=place, at_s=mission.clock.now_s())
    assert say(mission, seen) is Reception.RECORDED, "it need not be repeated"
    assert mission.facts == before
    mission.tell(THIEF, "interchange_1")
    assert (
        say(mission, seen.model_copy(update={"sample": "gem", "place": "interchange_1"}))
        is Reception.RECORDED
    )
    assert any(one.args == ("gem", "in", "interchange_1") for one in mission.facts)


def test_a_robot_answers_no_question_that_another_was_asked() -> None:
    questions = Questions(patience_s=0.2)
    forged = TraceReport(at_s=666.0)

    def answer_as(sender: str, in_reply_to: str) -> Message:
        return Message(
            performative=Performative.INFORM,
            sender=sender,
            receiver="service",
            sent_at_s=1.0,
            in_reply_to=in_reply_to,
            body=forged,
        )

    with ThreadPoolExecutor() as pool:
        asked = pool.submit(questions.trace, VICTIM, 1.0)
        question = awaited(lambda: questions.to_send([VICTIM]), bool)[0]
        assert questions.answered(answer_as(THIEF, question.id)), "it is dropped"
        with pytest.raises(Silent):
            asked.result()
        questions = Questions(patience_s=LONG_S)
        asked = pool.submit(questions.trace, VICTIM, 1.0)
        question = awaited(lambda: questions.to_send([VICTIM]), bool)[0]
        assert questions.answered(answer_as(VICTIM, question.id))
        assert asked.result() == forged
