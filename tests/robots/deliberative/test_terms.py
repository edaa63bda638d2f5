"""Terms and unification."""

from hypothesis import given
from hypothesis import strategies as st

from robots.deliberative.terms import (
    Term,
    Value,
    Variable,
    as_value,
    instance,
    is_ground,
    match,
    opposite,
    shown,
    substitute,
    unify,
)

leaves = st.one_of(
    st.sampled_from(["a", "b", "two words", 'with "quotes"']),
    st.integers(-3, 3).map(float),
    st.sampled_from("xyz").map(Variable),
)
values = st.recursive(
    leaves,
    lambda inner: st.builds(
        lambda name, args: Term(name, tuple(args)),
        st.sampled_from("fg"),
        st.lists(inner, min_size=1, max_size=2),
    ),
    max_leaves=6,
)


@given(values, values)
def test_a_unifier_makes_both_values_equal(left: Value, right: Value) -> None:
    bindings = unify(left, right)
    if bindings is not None:
        assert substitute(left, bindings) == substitute(right, bindings)


@given(values, values)
def test_unification_is_symmetric(left: Value, right: Value) -> None:
    assert (unify(left, right) is None) == (unify(right, left) is None)


@given(values, st.dictionaries(st.sampled_from("xyz"), st.sampled_from(["a", 1.0]), min_size=3))
def test_a_pattern_matches_each_of_its_instances(pattern: Value, bindings: dict[str, Value]) -> None:
    ground = substitute(pattern, bindings)
    found: dict[str, Value] = {}
    assert is_ground(ground)
    assert match(pattern, ground, found)
    assert substitute(pattern, found) == ground


def test_a_variable_does_not_unify_with_a_term_that_contains_it() -> None:
    assert unify(Variable("x"), Term("f", (Variable("x"),))) is None


def test_a_repeated_variable_stands_for_one_value() -> None:
    pattern = Term("beside", (Variable("x"), Variable("x")))
    assert not match(pattern, Term("beside", ("a", "b")), {})
    assert match(pattern, Term("beside", ("a", "a")), {})


def test_terms_are_shown_as_they_are_written() -> None:
    term = Term("home", ("left_defender", -1.5, "two words", Term("near", (Variable("who"),))))
    assert str(term) == 'home(left_defender, -1.5, "two words", near(?who))'
    assert shown(as_value(Term("startup"))) == "startup"


def test_the_opposite_of_an_opposite_is_the_term() -> None:
    close = Term("close", ("ball",))
    assert str(opposite(close)) == "not(close(ball))"
    assert opposite(opposite(close)) == close
    assert opposite(opposite(Term("startup"))) == Term("startup")


def test_an_instance_keeps_what_is_not_bound() -> None:
    assert str(instance(Term("f", (Variable("x"), Variable("y"))), {"x": 1.0})) == "f(1, ?y)"
