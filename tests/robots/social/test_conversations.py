"""Conversations between robots: answers in time, clarification of what is not understood, and who is known."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.social import Conversation, Conversations, Ending, Heard, Reply, Term
from robots.social.conversation import MAX_CONVERSATIONS
from robots.social.protocols import OPENED_BY, PROTOCOLS, QUERY, REQUEST, TIMED_OUT, InteractionProtocol
from robots.wire import MAX_TOLD_CONVERSATIONS, Message, Performative, SpeechAct
from tests.robots.social.talkers import Air, Talker
from tests.robots.stories import packet, script


def pair(**faults: float) -> tuple[Air, Talker, Talker]:
    air = Air(**faults)  # type: ignore[arg-type]
    return air, air.add("fred"), air.add("ginger")


def say(
    talker: Talker,
    content: str,
    performative: Performative = Performative.REQUEST,
    conversation: str = "c-1",
    **slots: str,
) -> Message:
    """Speak to ginger past the talker's own conversations."""
    reply = slots.pop("in_reply_to", None)
    act = SpeechAct(content=content, conversation_id=conversation, **{"protocol": "fipa-request", **slots})
    message = Message(
        performative=performative,
        sender=talker.name,
        receiver="ginger",
        sent_at_s=talker.air.clock.now_s(),
        in_reply_to=reply,
        body=act,
    )
    talker.air.send(message)
    return message


def told(message: Message) -> str:
    assert isinstance(message.body, SpeechAct)
    return message.body.content


def test_a_robot_is_known_from_when_it_is_heard_with_what_it_says_that_it_can() -> None:
    air, fred, ginger = pair()
    assert fred.social.acquaintances.of("ginger") is None
    question = Term("abilities")
    fred.social.say(Performative.QUERY_REF, "ginger", question, protocol=QUERY, within_s=10.0)
    air.run_for(3.0)
    known = fred.social.acquaintances.of("ginger")
    assert known is not None
    assert known.abilities == {"DOCK", "NAVIGATE"}
    assert known.heard_s == 1.0
    other = ginger.social.acquaintances.of("fred")
    assert other is not None
    assert other.abilities == frozenset()


def test_of_many_open_conversations_the_newest_are_told() -> None:
    _, fred, _ = pair()
    asked = Performative.QUERY_REF, "ginger", Term("abilities")
    names = [f"c-{number}" for number in range(MAX_TOLD_CONVERSATIONS + 2)]
    for name in names:
        fred.social.say(*asked, protocol=QUERY, within_s=10.0, conversation_id=name)
    assert [one.id for one in fred.social.told()] == names[-MAX_TOLD_CONVERSATIONS:]


@pytest.mark.parametrize(
    ("words", "slots", "reason"),
    [
        ("face(", {}, "column 6: expected a name, found the end"),
        ("face(yard_2)", {"language": "klingon"}, "klingon"),
        ("face(yard_2)", {"protocol": "fipa-auction"}, "fipa-contract-net"),
        ("face(yard_2)", {}, "does not take request of 'face'; it takes wave"),
        ("wave(yard_2)", {"performative": Performative.PROPOSE}, "is opened by request, not by propose"),
    ],
)
def test_what_is_not_understood_is_answered_with_what_would_be(
    words: str, slots: dict[str, str], reason: str
) -> None:
    air, fred, ginger = pair()
    ginger.social.on(
        Performative.REQUEST,
        "wave",
        lambda heard, robot: Reply(performative=Performative.AGREE, content=Term("wave")),
    )
    asked = say(fred, words, **slots)  # type: ignore[arg-type]
    air.run_for(20.0)
    assert len(air.sent) == 2, "a not-understood is not answered, or they would not come to an end"
    answer = air.sent[1]
    assert (answer.performative, answer.in_reply_to) == ("not-understood", asked.id)
    assert reason in told(answer)


def test_an_answer_that_does_not_follow_is_not_understood_and_changes_nothing() -> None:
    air, fred, ginger = pair()
    endings: list[Ending] = []
    ginger.social.on(Performative.REQUEST, "wave", lambda heard, robot: None)
    one = fred.social.say(
        Performative.REQUEST, "ginger", Term("wave"), protocol=REQUEST, within_s=60, ended=endings.append
    )
    air.run_for(1.0)
    wrong = Message(
        performative=Performative.PROPOSE,
        sender="ginger",
        receiver="fred",
        sent_at_s=0.0,
        in_reply_to=air.sent[0].id,
        body=SpeechAct(content="wave", protocol="fipa-request", conversation_id=one.id),
    )
    ginger.send(wrong)
    air.run_for(1.0)
    assert one.state == "requested"
    assert "agree or refuse or inform or failure may" in told(air.sent[-1])
    assert air.sent[-1].performative is Performative.NOT_UNDERSTOOD
    assert "propose by the participant does not follow in fipa-request, which is requested" in told(
        air.sent[-1]
    )


@pytest.mark.parametrize("seed", range(20))
def test_a_request_is_handled_once_and_answered_whatever_the_radio_does(seed: int) -> None:
    air, fred, ginger = pair(seed=seed, loss=0.4, longest_s=6.0, repeats=0.3)
    handled: list[Heard] = []
    endings: list[Ending] = []

    def wave(heard: Heard, robot: object) -> Reply:
        handled.append(heard)
        return Reply(performative=Performative.INFORM, content=Term("waved", ("yard_2",)))

    ginger.social.on(Performative.REQUEST, "wave", wave)
    fred.social.say(
        Performative.REQUEST, "ginger", Term("wave"), protocol=REQUEST, within_s=400, ended=endings.append
    )
    air.run_for(400.0)
    (ending,) = endings
    assert ending.state == "done"
    assert ending.answer is not None
    assert ending.answer.content == Term("waved", (Term("yard_2"),))
    assert len(handled) == 1


@pytest.mark.parametrize(
    ("content", "performative", "answer"),
    [
        (f'leg(a, "{"x" * 3970}")', Performative.CFP, "not-understood reason"),
        (f'leg("{"ä" * 700}", packet(NAVIGATE, 5, ref2(door)))', Performative.CFP, "refuse too_long"),
        (f'note("{"ä" * 700}")', Performative.INFORM, "confirm too_long"),
        (f'ended(s, "{"ä" * 700}")', Performative.INFORM, "refuse too_long"),
        (f'ended(script-ginger, "{"ä" * 700}")', Performative.INFORM, "refuse too_long"),
    ],
)
def test_an_answer_that_no_message_holds_says_so(
    content: str, performative: Performative, answer: str
) -> None:
    """Each of these characters is written as six."""
    air, fred, ginger = pair()
    ginger.accept(script("ginger", packet("NAVIGATE", ref2="door")))
    ginger.social.listen(lambda heard: True)
    say(fred, content, performative, protocol=OPENED_BY[performative].name)
    air.run_for(1.0)
    (said,) = air.sent[1:]
    assert f"{said.performative} {told(said)}".startswith(answer)


WORDS = st.sampled_from(["a", "s", '"ä b"', "leg_1", f'"{"ä" * 700}"', "-1", "1e300", "packet(STOP, 5)"])
CONTENTS = st.builds(
    lambda name, args: f"{name}({', '.join(args)})" if args else name,
    st.sampled_from(
        [
            "leg",
            "award",
            "reject",
            "withdrawn",
            "ended",
            "perform",
            "halt",
            "seen",
            "place",
            "holds",
            "note",
            "abilities",
        ]
    ),
    st.lists(WORDS, max_size=3),
)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(list(Performative)),
            CONTENTS,
            st.sampled_from([*PROTOCOLS, "other"]),
            st.sampled_from(["c-1", "c-2"]),
            st.sampled_from([("fred", ""), ("service", "ann")]),
        ),
        max_size=8,
    ),
    st.booleans(),
)
def test_nothing_that_is_said_stops_a_robot(
    acts: list[tuple[Performative, str, str, str, tuple[str, str]]], has_rules: bool
) -> None:
    air, _, ginger = pair()
    ginger.social.listen(lambda heard: has_rules)
    for performative, content, protocol, conversation, (sender, speaker) in acts:
        act = SpeechAct(content=content, protocol=protocol, conversation_id=conversation, speaker=speaker)
        air.send(
            Message(performative=performative, sender=sender, receiver="ginger", sent_at_s=0.0, body=act)
        )
        air.step()
    air.run_for(8.0)


def test_what_a_robot_says_again_names_the_message_that_it_has_heard_again() -> None:
    air, fred, ginger = pair()
    bids = Reply(performative=Performative.PROPOSE, content=Term("bid"))
    ginger.social.on(Performative.CFP, "wave", lambda heard, robot: bids)
    ginger.social.on(Performative.ACCEPT_PROPOSAL, "award", lambda heard, robot: None)
    called = say(fred, "wave", Performative.CFP, protocol="fipa-contract-net")
    air.run_for(1.0)
    bid = air.sent[-1]
    award = say(fred, "award", Performative.ACCEPT_PROPOSAL, protocol="fipa-contract-net", in_reply_to=bid.id)
    air.run_for(1.0)
    for copy in (award, called):
        fred.send(copy)
    air.run_for(1.0)
    again = [(one.id, one.in_reply_to) for one in air.sent if one.sender == "ginger"]
    assert again == [(bid.id, called.id), (bid.id, award.id), (bid.id, called.id)]


def test_the_copies_of_a_message_are_counted() -> None:
    air, fred, _ = pair(loss=1.0)
    fred.social.say(Performative.REQUEST, "ginger", Term("wave"), protocol=REQUEST, within_s=20.0)
    air.run_for(15.0)
    copies = [one.body.attempt for one in air.sent if isinstance(one.body, SpeechAct)]
    assert copies == [1, 2, 3, 4]
    assert len({one.id for one in air.sent}) == 1


@pytest.mark.parametrize("protocol", [REQUEST, QUERY], ids=["request", "query"])
def test_an_answer_that_does_not_come_in_time_ends_the_conversation(protocol: InteractionProtocol) -> None:
    air, fred, _ = pair(loss=1.0)
    endings: list[Ending] = []
    (opens, *_) = protocol.opens
    fred.social.say(opens, "ginger", Term("wave"), protocol=protocol, within_s=60, ended=endings.append)
    air.run_for(59.0)
    assert endings == []
    air.run_for(2.0)
    assert [(one.state, one.answer) for one in endings] == [(TIMED_OUT, None)]
    said = len(air.sent)
    air.run_for(60.0)
    assert len(air.sent) == said


def test_an_answer_to_a_conversation_before_a_restart_is_dropped() -> None:
    air, fred, ginger = pair()
    say(fred, "waved", Performative.INFORM, in_reply_to="long-ago")
    air.run_for(5.0)
    assert len(air.sent) == 1
    assert not list(ginger.social.conversations)


def test_conversations_that_have_ended_are_forgotten_before_open_ones() -> None:
    def opened(number: int) -> Conversation:
        act = SpeechAct(content="wave", protocol=REQUEST.name, conversation_id=f"c-{number}")
        message = Message(
            performative=Performative.REQUEST, sender="fred", receiver="ginger", sent_at_s=0.0, body=act
        )
        return Conversation(REQUEST, f"c-{number}", "fred", message, mine=False)

    known = Conversations()
    for number in range(MAX_CONVERSATIONS):
        known.add(opened(number))
    ended = known.of("c-7", "fred")
    assert ended is not None
    ended.cancel()
    known.add(opened(MAX_CONVERSATIONS))
    assert known.of("c-7", "fred") is None
    assert known.of("c-0", "fred") is not None
    known.add(opened(MAX_CONVERSATIONS + 1))
    assert known.of("c-0", "fred") is None, "all are open"
    assert len(list(known)) == MAX_CONVERSATIONS
