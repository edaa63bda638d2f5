"""The service speaks with robots: it repeats itself, takes each answer once, records both, and gives up in time."""

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents.agent_models import AgentModels
from app.agents.speech import Speech, SpeechService, end_conversations, end_with_robots, last_heard
from app.composition import Service
from app.core import Core
from app.domain.errors import Conflict, Invalid
from app.store import ConversationRow, Database, EventRow, GoalRow, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from planner import load_knowledge_base
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.social import Term
from robots.social.protocols import CONTRACT_NET, INFORM, QUERY
from robots.wire import MAX_CONTENT, Message, Performative, SpeechAct
from robots.world import LinkSpec, load_world
from tests.robots.social.talkers import Air, Talker
from tests.waiting import until

LAB = "lab"
"""A world that the service of the fixture does not run: nobody else speaks with its robots."""


class Desk:
    """A speech service in stepped time, and a robot with a social level that hears it at once."""

    def __init__(self, database: Database) -> None:
        self.air = Air()
        self.robot = Talker(self.air, "yard_1")
        self.database = database
        world = load_world("sample_store").model_copy(update={"name": LAB})
        robots = [
            one.model_copy(update={"external": True}) if one.name == "yard_2" else one for one in world.robots
        ]
        world = world.model_copy(update={"robots": tuple(robots)})
        events = EventLog(database)
        base = load_knowledge_base()
        nets = PlanNets(base)
        core = Core(
            database=database,
            events=events,
            facts=FactStore(events, base),
            workflows=None,  # type: ignore[arg-type]  # nothing durable happens here
            knowledge_base=base,
            plan_nets=nets,
            reservations=Reservations(nets),
        )
        self.pace: float | None = 1.0
        self.answer_s = world.links["yard_1"].answer_s
        self.speech = SpeechService(
            core, worlds={LAB: world}, clocks={LAB: self.air.clock}, paces={LAB: lambda: self.pace}
        )
        self.told: list[tuple[str, Performative | None]] = []
        self.speech.listen("tests", self._listen)

    def _listen(self, session: object, row: ConversationRow) -> None:
        heard = last_heard(row)
        self.told.append((row.state, None if heard is None else heard[0]))

    def ask(
        self,
        performative: Performative = Performative.QUERY_REF,
        within_s: float = 20.0,
        opener: str = "tests",
    ) -> ConversationRow:
        with self.database.write() as session:
            return self.speech.open(
                session,
                world=LAB,
                robot="yard_1",
                what="bids",
                performative=performative,
                content=Term("abilities"),
                protocol=QUERY,
                within_s=within_s,
                opener=opener,
                about="goal-1",
            )

    def call(self, opener: str, what: str = "leg", *, within_s: float = 20.0) -> ConversationRow:
        with self.database.write() as session:
            return self.speech.open(
                session,
                world=LAB,
                robot="yard_1",
                what="bids",
                performative=Performative.CFP,
                content=Term(what),
                protocol=CONTRACT_NET,
                within_s=within_s,
                opener=opener,
            )

    def tell(self, session: Session, content: Term) -> ConversationRow:
        return self.speech.open(
            session,
            world=LAB,
            robot="yard_1",
            what="bids",
            performative=Performative.INFORM,
            content=content,
            protocol=INFORM,
            within_s=20.0,
            opener="tests",
        )

    def carry(self, said: list[Speech]) -> list[Message]:
        """What the robot answers to what the service says."""
        before = len(self.air.sent)
        self.robot.step([message(one, self.air.clock) for one in said])
        return self.air.sent[before:]

    def hear(self, messages: list[Message]) -> list[Speech]:
        answers = list[Speech]()
        for one in messages:
            assert isinstance(one.body, SpeechAct)
            answers += self.speech.hear(LAB, one, one.body)
        return answers

    def row(self, one: ConversationRow) -> ConversationRow:
        with self.database.read() as session:
            return session.get_one(ConversationRow, (one.id, one.robot))

    def events(self, subject: str) -> list[tuple[str, str]]:
        with self.database.read() as session:
            query = select(EventRow).where(EventRow.subject == subject, EventRow.type == "speech.said")
            rows = session.scalars(query.order_by(EventRow.seq)).all()
            return [(row.data["sender"], row.data["performative"]) for row in rows]


def message(said: Speech, clock: ManualClock) -> Message:
    return Message(
        id=said.message_id,
        performative=said.performative,
        sender="service",
        receiver=said.robot,
        sent_at_s=clock.now_s(),
        in_reply_to=said.in_reply_to,
        body=said.act,
    )


@pytest.fixture
def desk(database: Database) -> Desk:
    return Desk(database)


def test_a_robot_answers_the_service_and_both_sides_are_recorded(desk: Desk) -> None:
    opened = desk.ask()
    desk.hear(desk.carry(desk.speech.due(LAB)))
    row = desk.row(opened)
    assert (row.state, row.is_over) == ("answered", True)
    heard = last_heard(row)
    assert heard is not None
    assert heard[1].words == ("DOCK", "NAVIGATE")
    assert desk.told == [("answered", Performative.INFORM)]
    assert desk.events("goal-1") == [("service", "query-ref"), ("yard_1", "inform")]
    assert desk.speech.due(LAB) == []


def test_what_is_not_answered_is_due_until_its_time_is_over(desk: Desk) -> None:
    opened = desk.ask(within_s=20.0)
    ids = {one.message_id for one in desk.speech.due(LAB)}
    desk.air.clock.advance(19.5)
    assert {one.message_id for one in desk.speech.due(LAB)} == ids
    desk.air.clock.advance(0.5)
    assert desk.speech.due(LAB) == []
    assert desk.row(opened).state == "timed_out"
    assert desk.told == [("timed_out", None)]


def test_an_answer_that_arrives_twice_is_taken_once(desk: Desk) -> None:
    desk.ask()
    answers = desk.carry(desk.speech.due(LAB))
    desk.hear([*answers, *answers])
    assert len(desk.told) == 1
    assert len(desk.events("goal-1")) == 2


def test_an_answer_after_the_time_is_over_changes_nothing(desk: Desk) -> None:
    opened = desk.ask()
    answers = desk.carry(desk.speech.due(LAB))
    desk.air.clock.advance(20.0)
    desk.speech.due(LAB)
    desk.hear(answers)
    assert desk.row(opened).state == "timed_out"


def offer_to(opened: ConversationRow) -> Message:
    return Message(
        performative=Performative.PROPOSE,
        sender="yard_1",
        receiver="service",
        sent_at_s=0.0,
        in_reply_to=opened.said[0]["id"],
        body=SpeechAct(content="bid(leg_1)", protocol=CONTRACT_NET.name, conversation_id=opened.id),
    )


def test_an_award_is_said_until_the_robot_has_heard_it_whatever_arrives_late(desk: Desk) -> None:
    def award(session: Session, row: ConversationRow) -> None:
        desk.speech.say(session, row, Performative.ACCEPT_PROPOSAL, Term("award", ("leg_1", "s")))

    desk.speech.listen("awards", award)
    opened = desk.call("awards")
    offered = offer_to(opened)
    desk.hear([offered, offered])
    (said,) = desk.speech.due(LAB)
    assert said.performative is Performative.ACCEPT_PROPOSAL
    desk.hear([offered.model_copy(update={"id": "said-again"})])
    assert [one.message_id for one in desk.speech.due(LAB)] == [said.message_id]
    desk.hear([offered.model_copy(update={"in_reply_to": said.message_id})])
    assert (desk.speech.due(LAB), desk.row(opened).state) == ([], "awarded")


def test_what_ends_a_conversation_is_due_until_it_was_sent_once(desk: Desk) -> None:
    opened = desk.call("tests")
    offered = offer_to(opened)
    desk.hear([offered])
    with desk.database.write() as session:
        row = session.get_one(ConversationRow, (opened.id, opened.robot))
        desk.speech.say(session, row, Performative.REJECT_PROPOSAL, Term("reject", ("leg_1",)))
    assert (desk.row(opened).state, desk.row(opened).is_over) == ("rejected", True)
    desk.hear([offered.model_copy(update={"id": "said-again"})])
    desk.air.clock.advance(100.0)
    (said,) = desk.speech.due(LAB)
    assert (said.performative, said.act.content, said.ends) == ("reject-proposal", "reject(leg_1)", True)
    assert [one.message_id for one in desk.speech.due(LAB)] == [said.message_id]
    desk.speech.was_said(said)
    assert desk.speech.due(LAB) == []
    assert desk.row(opened).state == "rejected"


def test_a_fast_world_leaves_its_robots_the_same_time_by_the_wall_clock(desk: Desk) -> None:
    assert desk.speech.patience_s(LAB, "yard_1", 2.0) == desk.answer_s + 2.0
    desk.pace = 20.0
    assert desk.speech.patience_s(LAB, "yard_1", 2.0) == desk.answer_s + 40.0
    desk.pace = 0.5
    assert desk.speech.patience_s(LAB, "yard_1", 2.0) == desk.answer_s + 2.0
    desk.pace = None
    assert desk.speech.patience_s(LAB, "yard_1", 2.0) == desk.answer_s + 400.0


def test_the_service_hears_that_it_was_not_understood(desk: Desk) -> None:
    opened = desk.call("tests", "dance", within_s=5.0)
    desk.hear(desk.carry(desk.speech.due(LAB)))
    row = desk.row(opened)
    assert row.state == "not_understood"
    assert "'dance'" in row.reason


def test_what_no_message_holds_is_refused_and_not_recorded(desk: Desk) -> None:
    with desk.database.write() as session, pytest.raises(Invalid, match="at most 4000"):
        desk.tell(session, Term("news", ("\U0001f600" * 400,)))
    assert desk.speech.due(LAB) == []


def test_what_cannot_be_sent_holds_up_nothing_else(desk: Desk) -> None:
    with desk.database.write() as session:
        kept = desk.tell(session, Term("news"))
        kept.said = [{**one, "content": "x" * (MAX_CONTENT + 1)} for one in kept.said]
    opened = desk.ask()
    assert [one.act.conversation_id for one in desk.speech.due(LAB)] == [opened.id]


def test_a_robot_that_does_not_speak_gives_a_reason_and_no_wait(desk: Desk) -> None:
    reason = desk.speech.unheard_reason(LAB, "yard_2", "bids")
    assert reason == "software of its own drives yard_2, and nothing states that it speaks bids"
    assert desk.speech.unheard_reason(LAB, "yard_1", "bids") == ""
    with desk.database.write() as session, pytest.raises(Conflict, match="yard_2"):
        desk.speech.open(
            session,
            world=LAB,
            robot="yard_2",
            what="bids",
            performative=Performative.QUERY_REF,
            content=Term("abilities"),
            protocol=QUERY,
            within_s=5.0,
            opener="tests",
        )
    assert desk.speech.due(LAB) == []


def test_what_a_robot_tells_the_service_is_recorded_and_confirmed(desk: Desk) -> None:
    desk.robot.social.say(Performative.INFORM, "service", Term("stuck"), protocol=INFORM, within_s=30.0)
    answers = desk.hear(desk.carry([]))
    assert [one.performative for one in answers] == [Performative.CONFIRM]
    assert desk.events("yard_1") == [("yard_1", "inform"), ("service", "confirm")]
    assert desk.carry(answers) == []
    assert {one.state for one in desk.robot.social.conversations} == {"confirmed"}


def test_what_is_repeated_to_the_service_gets_the_same_answer(desk: Desk) -> None:
    desk.robot.social.say(Performative.INFORM, "service", Term("stuck"), protocol=INFORM, within_s=30.0)
    said = desk.carry([])
    first, again = desk.hear([*said, *said])
    assert first == again
    assert len(desk.events("yard_1")) == 2


def test_what_a_robot_opens_otherwise_is_not_understood(desk: Desk) -> None:
    desk.robot.social.say(Performative.QUERY_REF, "service", Term("which"), protocol=QUERY, within_s=9.0)
    assert [one.performative for one in desk.hear(desk.carry([]))] == [Performative.NOT_UNDERSTOOD]


def test_what_is_too_long_to_be_said_back_is_confirmed_as_such(desk: Desk) -> None:
    """Each of these characters is written as six."""
    act = SpeechAct(content=f'news("{"ä" * 700}")', protocol=INFORM.name, conversation_id="c-1")
    told = Message(
        performative=Performative.INFORM, sender="yard_1", receiver="service", sent_at_s=0.0, body=act
    )
    (answer,) = desk.hear([told])
    assert (answer.performative, answer.act.content.startswith("too_long")) == ("confirm", True)


def test_answers_that_are_still_needed_outlast_a_robots_oldest_conversations(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.agents.speech.KEPT", 2)
    with desk.database.write() as session:
        goal = GoalRow(id="goal-1", world=LAB, text="", goal=[], priority=0, auto_approve=False)
        goal.state = "planning"
        goal.created_by = "tests"
        session.add(WorldRow(id=LAB, title="", layout={}, version=0))
        session.flush()
        session.add(goal)
    of_tender, unsent, forgotten = desk.ask(), desk.call("tests"), desk.call("tests")
    desk.hear([*desk.carry(desk.speech.due(LAB)[:1]), offer_to(unsent)])
    with desk.database.write() as session:
        row = session.get_one(ConversationRow, (unsent.id, unsent.robot))
        desk.speech.say(session, row, Performative.REJECT_PROPOSAL, Term("reject", ("leg_1",)))
        desk.speech.cancel(session.get_one(ConversationRow, (forgotten.id, forgotten.robot)), "")
    for _ in range(3):
        desk.call("tests")
    kept = {row.id for row in desk.speech.of_robot("yard_1", limit=100)}
    assert {of_tender.id, unsent.id, forgotten.id} & kept == {of_tender.id, unsent.id}


def test_nothing_is_left_to_say_to_a_robot_that_is_gone(desk: Desk) -> None:
    opened = desk.call("tests")
    desk.hear([offer_to(opened)])
    with desk.database.write() as session:
        row = session.get_one(ConversationRow, (opened.id, opened.robot))
        desk.speech.say(session, row, Performative.REJECT_PROPOSAL, Term("reject", ("leg_1",)))
    with desk.database.write() as session:
        end_with_robots(session, LAB, ["yard_2"])
    assert (desk.speech.due(LAB), desk.row(opened).state) == ([], "rejected")


def test_conversations_end_with_the_run_of_their_world(desk: Desk) -> None:
    opened = desk.ask()
    with desk.database.write() as session:
        end_conversations(session, LAB, "the world was started again")
    row = desk.row(opened)
    assert (row.state, row.reason) == ("cancelled", "the world was started again")
    assert desk.speech.due(LAB) == []


def test_agent_models_send_what_is_due_and_pass_answers_on(service: Service) -> None:
    desk = Desk(service.database)

    def fail(session: object, row: ConversationRow) -> None:
        raise IndexError("a mistake of the listener")

    desk.speech.listen("faulty", fail)
    desk.ask(opener="faulty")
    near, far = InMemoryLink.pair()
    agents = AgentModels(
        robots=lambda: {"yard_1": LinkSpec()},
        link=near,
        clock=desk.air.clock,
        database=service.database,
        reports=service.reports,
        board=service.board,
        questions=service.questions,
        teleoperation=service.teleoperation,
        tunings=service.tunings,
        rules=service.rules,
        speech=desk.speech,
        readmit=lambda: None,
        world=LAB,
    )
    agents.start()
    try:
        opened = desk.ask()

        def answered() -> bool:
            for one in far.receive():
                desk.robot.step([one])
            for one in desk.air.sent:
                far.send(one)
            desk.air.sent.clear()
            return desk.row(opened).is_over

        until(answered)
    finally:
        agents.close()
    assert desk.row(opened).state == "answered"


def test_the_api_lists_a_robots_conversations(api: TestClient, service: Service) -> None:
    with service.database.write() as session:
        service.speech.open(
            session,
            world="sample_store",
            robot="yard_1",
            what="bids",
            performative=Performative.QUERY_REF,
            content=Term("abilities"),
            protocol=QUERY,
            within_s=1000.0,
            opener="tests",
            speaker="Ada",
        )
    (item,) = api.get("/v1/robots/yard_1/conversations").json()["items"]
    assert (item["protocol"], item["state"], item["speaker"]) == ("fipa-query", "asked", "Ada")
    assert item["said"][0]["content"] == "abilities"
    assert api.get("/v1/robots/store_1/conversations").json()["items"] == []
    assert api.get("/v1/robots/nobody/conversations").status_code == 404
