"""What a robot answers, in words."""

import pytest

from app.domain.robot_language.answers import in_words
from robots.social import parse_term
from robots.wire import Performative


@pytest.mark.parametrize(
    ("performative", "content", "words"),
    [
        ("inform", "done(d1)", "done"),
        ("inform", "halted", "I have stopped"),
        ("inform", "seen", "I see nothing that I know"),
        ("inform", "seen(sample_1, door_1)", "I see sample_1 and door_1"),
        ("inform", "battery(0.5)", "my battery is at 50%"),
        ("inform", "held(nothing)", "I hold nothing"),
        ("inform", "sees(sample_1)", "yes, I see sample_1"),
        ("inform", "not(holds(sample_1))", "no, I do not hold sample_1"),
        ("inform", "not(seen(sample_1))", "no, I do not see sample_1"),
        ("inform", "activity(nothing)", "I do nothing"),
        ("inform", "activity(DOCK, running, m1)", "I am at DOCK, running"),
        ("inform", "abilities(DOCK, TRACK)", "I can DOCK and TRACK"),
        ("inform", "beliefs", "I believe nothing"),
        ("inform", 'beliefs("on_duty", "close(ball)")', "I believe on_duty and close(ball)"),
        ("inform", "place(sample_1, 1.5, 2)", "sample_1 is at (1.5, 2)"),
        (
            "inform",
            "position(x(1), y(2.5), heading(3.14159), near(bay_1))",
            "I am at (1, 2.5), near bay_1, heading 180°",
        ),
        ("inform", "position(x(1))", "position(x(1))"),
        ("inform", "position(x(1), y(2))", "position(x(1), y(2))"),
        ("inform", "position(x(1), heading(0))", "position(x(1), heading(0))"),
        ("inform", "held", "held"),
        ("inform", "sees", "sees"),
        ("inform", "activity(DOCK)", "activity(DOCK)"),
        ("inform", "covered(bay_3)", "covered(bay_3)"),
        ("agree", "agreed(d1)", "yes, I do"),
        ("agree", "seen", "I look"),
        ("agree", "cover_role(attacker)", "yes: cover_role(attacker)"),
        ("confirm", "news", "my rules have heard news"),
        ("refuse", 'refused("low")', "no: low"),
        ("failure", 'failed(d1, "stuck")', "I could not: stuck"),
        ("not-understood", 'reason("what")', "I do not understand: what"),
        ("propose", "bid(1)", "bid(1)"),
    ],
)
def test_an_answer_is_a_sentence(performative: str, content: str, words: str) -> None:
    assert in_words(Performative(performative), parse_term(content)) == words
