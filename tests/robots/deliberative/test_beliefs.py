"""The belief store."""

import pytest

from robots.deliberative.beliefs import MAX_BELIEFS, Belief, BeliefStore, Origin
from robots.deliberative.terms import Term, Variable, opposite
from robots.errors import RuleError

CLOSE = Term("close", ("ball",))


def belief(term: Term, origin: Origin = Origin.ADOPTED, since_s: float = 0.0) -> Belief:
    return Belief(term=term, origin=origin, since_s=since_s, source="test")


def test_a_belief_has_a_value_an_age_and_a_source() -> None:
    known = belief(opposite(CLOSE), since_s=3.0)
    assert (known.about, known.value, known.since_s, known.source) == (CLOSE, False, 3.0, "test")


def test_a_term_replaces_its_opposite() -> None:
    store = BeliefStore()
    store.adopt(belief(CLOSE))
    assert store.adopt(belief(opposite(CLOSE))) == (CLOSE, opposite(CLOSE))
    assert CLOSE not in store
    assert len(store) == 1


def test_a_belief_that_is_adopted_again_keeps_its_age_and_lasts() -> None:
    store = BeliefStore()
    store.adopt(belief(CLOSE, Origin.EVENT, 1.0))
    assert store.adopt(belief(CLOSE, Origin.ADOPTED, 2.0)) == ()
    known = store.get(CLOSE)
    assert known is not None
    assert (known.origin, known.since_s) == (Origin.ADOPTED, 1.0)


def test_the_index_gives_the_fewest_candidates() -> None:
    store = BeliefStore()
    for number in range(50):
        store.adopt(belief(Term("at", (f"robot_{number}", "yard" if number else "bay"))))
    assert list(store.candidates("at", 2, [(1, "bay")])) == [Term("at", ("robot_0", "bay"))]
    assert len(store.candidates("at", 2, [])) == 50
    assert not store.candidates("at", 2, [(0, "robot_1"), (1, "moon")])
    store.retract(Term("at", ("robot_0", "bay")))
    assert not store.candidates("at", 2, [(1, "bay")])


def test_a_belief_with_a_variable_is_refused() -> None:
    with pytest.raises(RuleError, match=r"a belief has no variables: close\(\?x\)"):
        BeliefStore().adopt(belief(Term("close", (Variable("x"),))))


def test_there_is_a_limit_to_what_is_believed() -> None:
    store = BeliefStore()
    for number in range(MAX_BELIEFS):
        store.adopt(belief(Term("n", (float(number),))))
    with pytest.raises(RuleError, match="there are 10000 beliefs already"):
        store.adopt(belief(CLOSE))
