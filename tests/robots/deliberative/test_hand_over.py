"""An agent that is written down between two cycles goes on from there as it would have."""

from copy import deepcopy

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.deliberative.actuators import DONE, Outcome
from robots.deliberative.agent import Agent
from robots.deliberative.lint import check
from robots.deliberative.reader import rules_of
from robots.deliberative.stored import restored, stored
from robots.deliberative.terms import Term, Value, Variable
from robots.errors import RuleError
from robots.executive.mind_memory import AgentMemory
from robots.repertoire import load_repertoire
from tests.robots.deliberative.fake_actuators import FakeActuators

RULES = """AGENT tester;
ACTUATOR activate, say, suspend, giveUp;
BELIEF(place(door_1)); BELIEF(place(bay_1));
BELIEF(message(request, ?who, adopt(?what))) => COMMIT(adoptBelief(wanted(?what)));
BELIEF(message(request, ?who, retract(?what))) => COMMIT(retractBelief(wanted(?what)));
BELIEF(wanted(?what)) => COMMIT(?what, Now + 2, BELIEF(wanted(?what)),
    SEQ(say(inform, ?what, begun), activate(STOP()), DELAY(1.5), say(inform, ?what, done)));
BELIEF(wanted(a)) & !BELIEF(wanted(b)) => COMMIT(PAR(activate(STOP()), say(inform, anna, alone), DELAY(3)));
BELIEF(message(request, ?who, choose)) => COMMIT(OR(go(?who), say(failure, ?who, go)));
BELIEF(message(request, ?who, wait)) => COMMIT(SEQ(AWAIT(BELIEF(wanted(b))), say(inform, ?who, b_is_wanted)));
BELIEF(fulfilled(?what)) => COMMIT(say(inform, clerk, fulfilled(?what)));
BELIEF(failed(?what)) => COMMIT(say(inform, clerk, failed(?what)));
PLAN go(?who) WHEN BELIEF(place(?place)) COST way(?place) + 1
    { activate(MOVE_TO(object: ?place)); say(inform, ?who, at(?place)); }
PLAN go(?who) WHEN BELIEF(wanted(c)) COST 0 { say(inform, ?who, c); }
"""
SAID = st.sampled_from(
    ["adopt(a)", "adopt(b)", "adopt(c)", "retract(a)", "retract(b)", "retract(c)", "choose", "wait"]
)
HAPPENS = st.tuples(st.lists(SAID, max_size=2), st.sampled_from([None, DONE, Outcome(False, "stuck")]))
VALUES = st.recursive(
    st.text(max_size=5) | st.integers(-9, 9) | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.builds(Term, st.text(min_size=1, max_size=4), st.lists(inner, max_size=3).map(tuple)),
    max_leaves=6,
)


def made(actuators: FakeActuators) -> Agent:
    files = [rules_of(RULES, "tester.rules")]
    check(files, load_repertoire())
    return Agent("tester", files, actuators, known=[Term("me", ("fred",))])


def heard(text: str) -> Term:
    name, _, rest = text.partition("(")
    content = Term(name, (rest.rstrip(")"),)) if rest else name
    return Term("message", ("request", "anna", content))


def cycle(
    one: Agent, actuators: FakeActuators, now_s: float, happens: tuple[list[str], Outcome | None]
) -> None:
    said, outcome = happens
    for attempt in actuators.begun:
        attempt.outcome = attempt.outcome or outcome
    one.cycle(now_s, [heard(text) for text in said])


def state(one: Agent, actuators: FakeActuators) -> object:
    return (
        [(belief.term, belief.origin, belief.since_s, belief.source) for belief in one.beliefs],
        [(made.number, made.origin, made.state, made.due_s, made.words) for made in one.commitments],
        [
            (attempt.wanted.tag, dict(attempt.wanted.arguments), attempt.outcome)
            for attempt in actuators.begun
        ],
        actuators.said,
    )


@settings(max_examples=150, deadline=None)
@given(before=st.lists(HAPPENS, max_size=8), after=st.lists(HAPPENS, min_size=1, max_size=8))
def test_what_is_written_down_goes_on_as_it_would_have(
    before: list[tuple[list[str], Outcome | None]], after: list[tuple[list[str], Outcome | None]]
) -> None:
    actuators = FakeActuators(measures={("way", "door_1"): 3.0, ("way", "bay_1"): 7.0})
    one = made(actuators)
    for number, happens in enumerate(before):
        cycle(one, actuators, float(number), happens)
    text = one.memory().model_dump_json()
    others = deepcopy(actuators)
    other = made(others)
    other.recall(AgentMemory.model_validate_json(text))
    assert other.memory().model_dump_json() == text
    for number, happens in enumerate(after, start=len(before)):
        cycle(one, actuators, float(number), happens)
        cycle(other, others, float(number), happens)
        assert state(other, others) == state(one, actuators)


@given(VALUES)
def test_a_value_is_the_same_when_it_is_read_again(value: Value) -> None:
    assert restored(stored(value)) == value
    assert restored(stored(Term("f", (value, Variable("x"))))) == Term("f", (value, Variable("x")))


@pytest.mark.parametrize("data", [True, None, ["f"], [1, []], {"variable": 1}, ["f", [None]]])
def test_data_that_hold_no_value_are_refused(data: object) -> None:
    with pytest.raises(RuleError, match="is no stored value"):
        restored(data)


def test_the_memory_of_other_rules_is_refused() -> None:
    actuators = FakeActuators()
    one = made(actuators)
    cycle(one, actuators, 0.0, (["wait"], None))
    memory = one.memory()
    other = Agent("tester", [rules_of("AGENT tester;\nACTUATOR say;", "tester.rules")], FakeActuators())
    with pytest.raises(RuleError, match="tester has no rule"):
        other.recall(memory)
