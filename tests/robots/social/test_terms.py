"""Contents of speech acts: what is written is read again, and what is no term is refused with its column."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.social import ContentError, Term, parse_term

CHARACTERS = st.characters(exclude_categories=["Cs"], exclude_characters="\0")
NAMES = st.one_of(
    st.from_regex(r"[A-Za-z_][A-Za-z0-9_.\-]{0,8}", fullmatch=True), st.text(CHARACTERS, max_size=8)
)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
TERMS = st.recursive(
    st.builds(Term, NAMES),
    lambda inner: st.builds(
        Term, NAMES, st.lists(st.one_of(inner, NUMBERS), min_size=1, max_size=3).map(tuple)
    ),
    max_leaves=6,
)


@given(term=TERMS)
def test_a_term_is_read_as_it_was_written(term: Term) -> None:
    assert parse_term(str(term)) == term


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "column 1: expected a name, found the end"),
        ("ended(", "column 7: expected a name, found the end"),
        ("ended(a5", "column 9: expected , or ), found the end"),
        ("ended(a5) a6", "column 11: expected the end, found a6"),
        ("ended(a5; a6)", "column 9: '; a6)' is no part of a term"),
        ("7", "column 1: expected a name, found 7"),
        ("turn(-1e999)", "column 6: -1e999 is too large for a number"),
        ('say("\\q")', "column 5"),
        ('say("a\\u0000")', "column 5: text with a NUL"),
        ('say("a\\ud800")', "column 5: text with a NUL or a lone surrogate"),
        ("a(" * 20 + "b" + ")" * 20, "nested deeper than 16"),
    ],
)
def test_what_is_no_term_is_refused_with_its_column(text: str, words: str) -> None:
    with pytest.raises(ContentError) as caught:
        parse_term(text)
    assert words in str(caught.value)


def test_the_words_of_a_term_are_its_arguments_as_text() -> None:
    assert parse_term('ended("m:1", a5, 2.5, f(x))').words == ("m:1", "a5", "2.5", "f(x)")
