"""Closure and reduction of orderings."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.errors import CyclicOrder
from planner.plan_nets.precedence import Precedence, in_sequence, members

Pairs = set[tuple[int, int]]
NODES = 9


@st.composite
def acyclic(draw: st.DrawFn) -> Pairs:
    """Pairs that agree with some order of the nodes, not always the numbers' own."""
    rank = draw(st.permutations(range(NODES)))
    return {
        (a, b) if rank[a] < rank[b] else (b, a)
        for a, b in draw(st.sets(st.tuples(*[st.integers(0, NODES - 1)] * 2)))
        if a != b
    }


def closure(pairs: Pairs) -> Pairs:
    """By repetition, as the definition has it."""
    closed = set(pairs)
    while more := {(a, d) for a, b in closed for c, d in closed if b == c} - closed:
        closed |= more
    return closed


@given(pairs=acyclic())
def test_before_and_after_are_the_transitive_closure(pairs: Pairs) -> None:
    precedence = Precedence.of(NODES, pairs)
    assert {(a, b) for a in range(NODES) for b in members(precedence.after[a])} == closure(pairs)
    assert {(a, b) for b in range(NODES) for a in members(precedence.before[b])} == closure(pairs)


@given(pairs=acyclic())
def test_the_reduction_is_the_least_with_the_same_closure(pairs: Pairs) -> None:
    reduction = set(Precedence.of(NODES, pairs).reduction())
    assert reduction <= pairs
    assert closure(reduction) == closure(pairs)
    assert all(closure(reduction - {pair}) != closure(pairs) for pair in reduction)


def test_a_cycle_is_refused_with_those_on_it_or_behind_it() -> None:
    with pytest.raises(CyclicOrder) as refusal:
        Precedence.of(5, [(0, 1), (1, 2), (2, 1), (2, 3)])
    assert refusal.value.nodes == [1, 2, 3]


@given(pairs=acyclic())
def test_the_sequence_keeps_all_pairs_and_the_numbers_order_where_it_can(pairs: Pairs) -> None:
    order = in_sequence(NODES, pairs)
    place = {node: at for at, node in enumerate(order)}
    assert sorted(order) == list(range(NODES))
    assert all(place[a] < place[b] for a, b in pairs)
    assert in_sequence(NODES, {(a, b) for a, b in pairs if a < b}) == list(range(NODES))


def test_a_sequence_of_a_cycle_is_refused_with_those_on_it_or_behind_it() -> None:
    with pytest.raises(CyclicOrder) as refusal:
        in_sequence(4, [(0, 1), (1, 1), (1, 2)])
    assert refusal.value.nodes == [1, 2]
