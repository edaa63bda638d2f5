"""Robots whose rules speak with each other."""

import pytest

from robots.deliberative.commitments import CommitmentState
from robots.deliberative.mind import Mind
from robots.deliberative.reader import rules_of
from robots.deliberative.terms import Term as RuleTerm
from robots.deliberative.terms import Variable
from robots.executive.mind_memory import MindMemory
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.repertoire import load_repertoire
from robots.social import RuleSpeech, Term, parse_term
from robots.social.protocols import OPENED_BY, TIMED_OUT, RequestState
from robots.social.rule_speech import WITHIN_S, as_content, as_rule_value
from robots.wire import Message, Performative, SpeechAct
from tests.robots.social.talkers import Air, Talker

CAPTAIN = """AGENT captain;
ACTUATOR say;
BELIEF(startup) => COMMIT(say(request, ginger, cover("bay 3", -1.5)));
BELIEF(message(agree, ginger, cover(?place, ?y))) => COMMIT(adoptBelief(agreed(?place, ?y)));
BELIEF(message(inform, ginger, covered(?place))) => COMMIT(adoptBelief(covered(?place)));
"""
KEEPER = """AGENT keeper;
ACTUATOR say;
BELIEF(message(request, ?who, cover(?place, ?y))) & ?y < 0
    => COMMIT(SEQ(say(agree, ?who, cover(?place, ?y)), DELAY(10), say(inform, ?who, covered(?place))));
"""


class Speaker:
    """A talker with rules."""

    def __init__(self, talker: Talker, text: str) -> None:
        start = Pose(x_m=0, y_m=0, heading_rad=0)
        profile = RobotProfile(name=talker.name, start=start, beacons={})
        self.talker = talker
        self._profile = profile
        self._text = text
        self.mind = self._made()

    def _made(self) -> Mind:
        speech = RuleSpeech(self.talker.social)
        files = [rules_of(self._text, self.talker.name)]
        mind = Mind(self._profile, load_repertoire(), files, speak=speech.speak)
        speech.listen(mind)
        return mind

    def hand_over(self) -> None:
        """Another program goes on with its mind."""
        memory = self.mind.hand_over().model_dump_json()
        self.talker.hand_over()
        self.mind = self._made()
        self.mind.recall(MindMemory.model_validate_json(memory), self.talker.air.clock.now_s())

    def cycle(self) -> None:
        self.mind.cycle(self.talker.executive, None, self.talker.air.clock.now_s())

    @property
    def beliefs(self) -> set[str]:
        return {str(term) for agent in self.mind.agents for term in agent.lasting()}

    @property
    def failures(self) -> list[str]:
        return [
            one.words
            for agent in self.mind.agents
            for one in agent.ended
            if one.state is CommitmentState.FAILED
        ]

    @property
    def states(self) -> list[str]:
        return [one.state for one in self.talker.social.conversations]


def speakers(fred: str, ginger: str, **faults: float) -> tuple[Air, Speaker, Speaker]:
    air = Air(**faults)  # type: ignore[arg-type]
    return air, Speaker(air.add("fred"), fred), Speaker(air.add("ginger"), ginger)


def run_for(air: Air, time_s: float, *who: Speaker) -> None:
    for _ in range(round(time_s / 0.5)):
        air.step()
        for one in who:
            one.cycle()


def said(air: Air) -> list[tuple[str, str, str]]:
    return [
        (one.sender, one.performative, one.body.content)
        for one in air.sent
        if isinstance(one.body, SpeechAct)
    ]


def test_a_rule_asks_and_the_others_rule_answers_in_the_same_conversation() -> None:
    air, fred, ginger = speakers(CAPTAIN, KEEPER)
    run_for(air, 5.0, fred, ginger)
    assert fred.beliefs == {'agreed("bay 3", -1.5)'}
    run_for(air, 15.0, fred, ginger)
    assert fred.beliefs == {'agreed("bay 3", -1.5)', 'covered("bay 3")'}
    assert fred.states == ginger.states == [RequestState.DONE]
    assert ginger.failures == fred.failures == []


@pytest.mark.parametrize("seed", range(3))
def test_rules_hear_each_message_once_whatever_the_radio_does(seed: int) -> None:
    count = (
        CAPTAIN
        + "BELIEF(message(inform, ?who, ?_)) & BELIEF(covered(?p)) => COMMIT(adoptBelief(again(?p)));\n"
    )
    air, fred, ginger = speakers(count, KEEPER, seed=seed, loss=0.3, longest_s=3.0, repeats=0.5)
    run_for(air, 60.0, fred, ginger)
    assert 'covered("bay 3")' in fred.beliefs
    assert 'again("bay 3")' not in fred.beliefs
    said_before = len(air.sent)
    run_for(air, 60.0, fred, ginger)
    assert len(air.sent) == said_before, "a conversation that has ended is silent"


@pytest.mark.parametrize("after_s", [0.5, 2.0, 5.0, 9.5, 14.0])
@pytest.mark.parametrize("seed", range(2))
def test_rules_that_go_on_in_another_program_ask_and_answer_each_once(seed: int, after_s: float) -> None:
    count = (
        CAPTAIN
        + "BELIEF(message(?what, ?who, ?_)) & BELIEF(covered(?p)) => COMMIT(adoptBelief(again(?p)));\n"
    )
    once = KEEPER + "BELIEF(message(request, ?_, ?_)) & BELIEF(once) => COMMIT(adoptBelief(twice));\n"
    once += "BELIEF(message(request, ?_, ?_)) => COMMIT(adoptBelief(once));\n"
    air, fred, ginger = speakers(count, once, seed=seed, loss=0.3, longest_s=3.0, repeats=0.5)
    run_for(air, after_s, fred, ginger)
    fred.hand_over()
    ginger.hand_over()
    run_for(air, 80.0, fred, ginger)
    assert fred.beliefs == {'agreed("bay 3", -1.5)', 'covered("bay 3")'}
    assert ginger.beliefs == {"once"}
    assert fred.states == ginger.states == [RequestState.DONE]
    assert ginger.failures == fred.failures == []


def test_what_is_said_when_an_answer_is_no_longer_awaited_opens_a_new_conversation() -> None:
    asks = """AGENT asks;
ACTUATOR say;
BELIEF(startup) => COMMIT(say(request, ginger, help));
BELIEF(message(inform, ginger, ?x)) => COMMIT(adoptBelief(told(?x)));
"""
    late = f"""AGENT late;
ACTUATOR say;
BELIEF(message(request, ?who, help)) => COMMIT(Self, Now + {2 * WITHIN_S}, say(inform, fred, fire));
"""
    air, fred, ginger = speakers(asks, late)
    run_for(air, WITHIN_S + 2.0, fred, ginger)
    assert fred.states == ginger.states == [TIMED_OUT]
    run_for(air, WITHIN_S + 2.0, fred, ginger)
    assert fred.beliefs == {"told(fire)"}


def test_an_inform_that_rules_take_is_confirmed_and_what_no_rule_matches_is_not_understood() -> None:
    teller = (
        "AGENT teller;\nACTUATOR say;\n"
        "BELIEF(startup) => COMMIT(PAR(say(inform, ginger, sunny), say(request, ginger, dance)));\n"
    )
    hearer = (
        "AGENT hearer;\nBELIEF(message(inform, ?who, ?what)) => COMMIT(adoptBelief(told(?who, ?what)));\n"
    )
    air, fred, ginger = speakers(teller, hearer)
    run_for(air, 5.0, fred, ginger)
    assert ginger.beliefs == {"told(fred, sunny)"}
    assert ("ginger", "confirm", "sunny") in said(air)
    assert [one[1] for one in said(air) if "dance" in one[2] and one[0] == "ginger"] == ["not-understood"]


def person_says(air: Air, robot: str, performative: Performative, content: str) -> None:
    protocol = OPENED_BY[performative].name
    act = SpeechAct(content=content, protocol=protocol, conversation_id=f"c-{content}", speaker="ann")
    air.send(
        Message(
            performative=performative,
            sender="service",
            receiver=robot,
            sent_at_s=air.clock.now_s(),
            body=act,
        )
    )


def test_rules_hear_a_person_by_name_and_answer_in_the_conversation_through_the_service() -> None:
    air, _, ginger = speakers("AGENT idle;\nBELIEF(startup) => COMMIT(adoptBelief(up));\n", KEEPER)
    person_says(air, "ginger", Performative.REQUEST, 'cover("bay 3", -1.5)')
    run_for(air, 15.0, ginger)
    assert said(air)[1:] == [
        ("ginger", "agree", 'cover("bay 3", -1.5)'),
        ("ginger", "inform", 'covered("bay 3")'),
    ]
    assert {one.receiver for one in air.sent[1:]} == {"service"}


def test_rules_may_take_any_performative_of_a_person_and_its_confirmation_says_that_they_have() -> None:
    hearer = "AGENT hearer;\nBELIEF(message(propagate, ?who, news)) => COMMIT(adoptBelief(told(?who)));\n"
    air, _, ginger = speakers("AGENT idle;\nBELIEF(startup) => COMMIT(adoptBelief(up));\n", hearer)
    person_says(air, "ginger", Performative.PROPAGATE, "news")
    person_says(air, "ginger", Performative.SUBSCRIBE, "weather")
    run_for(air, 5.0, ginger)
    assert ginger.beliefs == {"told(ann)"}
    answers = [(one[1], one[2]) for one in said(air) if one[0] == "ginger"]
    assert answers[0] == ("confirm", "news")
    assert answers[1][0] == "not-understood"


def test_what_cannot_be_said_fails_with_the_reason() -> None:
    text = (
        "AGENT mute;\nACTUATOR say;\n"
        "BELIEF(startup) => COMMIT(say(agree, ginger, dance));\n"
        "BELIEF(startup) => COMMIT(say(inform, ginger, 3));\n"
    )
    air, fred, ginger = speakers(text, "AGENT idle;\nBELIEF(startup) => COMMIT(adoptBelief(up));\n")
    run_for(air, 1.0, fred, ginger)
    assert fred.failures == [
        "agree answers nothing that ginger has said",
        "3 is no content: it is neither a name nor a term without variables",
    ]
    assert air.sent == []


def test_what_is_never_answered_ends_in_time() -> None:
    air, fred, ginger = speakers(CAPTAIN, KEEPER, loss=1.0)
    run_for(air, 70.0, fred, ginger)
    assert fred.states == [TIMED_OUT]


def test_contents_are_the_same_to_rules_and_to_the_social_level() -> None:
    content = parse_term('cover("bay 3", -1.5, near(yard_2, deep(x)), up)')
    value = as_rule_value(content)
    assert value == RuleTerm(
        "cover", ("bay 3", -1.5, RuleTerm("near", ("yard_2", RuleTerm("deep", ("x",)))), "up")
    )
    assert as_content(value) == content
    assert as_content("up") == Term("up")
    assert as_content(2.0) is None
    assert as_content(RuleTerm("up", (RuleTerm("of", (Variable("x"),)),))) is None


def test_open_conversations_are_told_and_ended_ones_are_not() -> None:
    air, fred, ginger = speakers(CAPTAIN, KEEPER)
    run_for(air, 5.0, fred, ginger)
    (mine,) = fred.talker.social.told()
    (theirs,) = ginger.talker.social.told()
    assert (mine.partner, mine.is_mine, theirs.partner, theirs.is_mine) == ("ginger", True, "fred", False)
    assert (mine.id, mine.state) == (theirs.id, RequestState.AGREED)
    run_for(air, 15.0, fred, ginger)
    assert fred.talker.social.told() == ginger.talker.social.told() == ()
