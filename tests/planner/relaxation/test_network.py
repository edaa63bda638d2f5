"""The closure of one rule against all its bindings."""

from itertools import combinations, product

from hypothesis import given, settings
from hypothesis import strategies as st

from planner import Fact
from planner.knowledge.literal import Literal
from planner.relaxation.network import Closure, Network
from planner.relaxation.rules import Rule

NAMES = ("n1", "n2", "n3")
VARIABLES = ("a", "b", "c", "d")
PREDICATES = ("p", "q", "r")
PAIRS = tuple(combinations(VARIABLES, 2))


@st.composite
def rules(draw: st.DrawFn) -> Rule:
    """What holds of one of four variables; those that only have to differ from others are left out on the way."""
    body = tuple(Literal(predicate, tuple(draw(st.permutations(VARIABLES))[:2])) for predicate in PREDICATES)
    bound = sorted({term for literal in body for term in literal.terms})
    head = Literal("head", (draw(st.sampled_from(bound)),))
    distinct = tuple(draw(st.lists(st.sampled_from(PAIRS), unique=True, max_size=4)))
    return Rule(
        head=head,
        body=body,
        types=dict.fromkeys(bound, "name"),
        distinct=tuple(pair for pair in distinct if {*pair} <= {*bound}),
    )


facts = st.sets(
    st.builds(Fact, st.sampled_from(PREDICATES), st.sampled_from(tuple(product(NAMES, repeat=2)))),
    max_size=14,
)


@settings(max_examples=300, deadline=None)
@given(rules(), facts)
def test_a_rule_brings_about_what_any_of_its_bindings_does(rule: Rule, given_facts: set[Fact]) -> None:
    terms = sorted(rule.types)
    bindings = (dict(zip(terms, values, strict=True)) for values in product(NAMES, repeat=len(terms)))
    expected = {
        binding[rule.head.terms[0]]
        for binding in bindings
        if all(binding[one] != binding[other] for one, other in rule.distinct)
        and all(
            Fact(literal.predicate, tuple(binding[term] for term in literal.terms)) in given_facts
            for literal in rule.body
        )
    }
    network = Network(
        [rule],
        members={"name": frozenset(NAMES)},
        types={**dict.fromkeys(PREDICATES, ("name", "name")), "head": ("name",)},
        kept={**dict.fromkeys(PREDICATES, (0, 1)), "head": (0,)},
    )
    closure = Closure(network, given_facts, ())
    assert {name for name in NAMES if closure.holds(Fact("head", (name,)))} == expected
