"""Goals in an order: what achieves one waits for what achieves those before it; nothing else does."""

from collections.abc import Mapping
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner import Fact, GroundAction, OrderingReason
from planner.errors import CyclicOrder, OrderNotKept
from planner.plan_nets.extraction import extract
from planner.plan_nets.orders import cycle_in, fewest_stages, orders_among
from tests.planner.plan_nets.test_extraction import act

P, Q, R = map(Fact, "pqr")
ONE = act("one", intends=["p"])
OTHER = act("other", intends=["q"])
LAST = act("last", intends=["r"])
Orders = Mapping[Fact, frozenset[Fact]]


def after(**orders: str) -> Orders:
    """By goal, the letters of those it comes after."""
    return {Fact(goal): frozenset(map(Fact, earlier)) for goal, earlier in orders.items()}


def orderings(*sequence: GroundAction, facts: str = "", **orders: str) -> dict[tuple[str, str], str]:
    order = extract(sequence, frozenset(map(Fact, facts)), (P, Q, R), after=after(**orders))
    tags = [action.tag for action in order.actions]
    return {(tags[one], tags[two]): reason for (one, two), reason in order.orderings.items()}


def test_what_achieves_a_goal_follows_what_achieves_the_one_before_and_the_rest_is_free() -> None:
    assert orderings(ONE, OTHER, LAST, r="p") == {("one", "last"): OrderingReason.ORDER}


def test_the_sequence_need_not_be_in_that_order() -> None:
    assert orderings(LAST, OTHER, ONE, r="p") == {("one", "last"): OrderingReason.ORDER}


def test_what_only_prepares_an_achievement_does_not_wait() -> None:
    ready = act("ready", intends=["x"])
    needy = act("last", needs=["x"], intends=["r"])
    found = orderings(ready, needy, OTHER, ONE, r="p")
    assert found == {
        ("ready", "last"): OrderingReason.CAUSAL,
        ("one", "last"): OrderingReason.ORDER,
    }


def test_an_ordering_that_is_there_for_another_reason_keeps_it() -> None:
    needy = act("last", needs=["p"], intends=["r"])
    assert orderings(ONE, OTHER, needy, r="p") == {("one", "last"): OrderingReason.CAUSAL}


@pytest.mark.parametrize("holds", ["p", "r"])
def test_a_goal_that_holds_already_neither_waits_nor_is_waited_for(holds: str) -> None:
    sequence = [one for one in (LAST, OTHER, ONE) if Fact(holds) not in one.intended_effects]
    assert orderings(*sequence, facts=holds, r="p") == {}


def test_what_is_under_way_does_not_wait() -> None:
    assert orderings(replace(LAST, under_way=True), OTHER, ONE, r="p") == {}


def test_all_that_brings_a_goal_about_waits() -> None:
    early = act("early", intends=["x"], other=["r"])
    user = act("other", needs=["x"], intends=["q"])
    found = orderings(early, user, ONE, LAST, r="p")
    assert ("one", "early") in found


def test_an_order_that_the_actions_contradict_is_refused_with_the_goals() -> None:
    needy = act("one", needs=["r"], intends=["p"])
    with pytest.raises(OrderNotKept, match=r"r\(?\)? comes true before p\(?\)?, after which"):
        orderings(LAST, needy, OTHER, r="p")


def test_goals_that_come_true_at_once_do_not_come_true_one_after_the_other() -> None:
    both = act("both", intends=["p", "r"])
    with pytest.raises(OrderNotKept):
        orderings(both, OTHER, r="p")


def test_only_orders_of_goals_that_there_are_count() -> None:
    assert orders_among((P, R), after(r="pq", q="p", p="q")) == after(r="p")


def test_the_fewest_stages_put_each_goal_behind_those_before_it() -> None:
    assert fewest_stages((P, Q, R), after(r="p")) == {R: 1}
    assert fewest_stages((P, Q, R), after(r="q", q="p")) == {Q: 1, R: 2}
    with pytest.raises(CyclicOrder):
        fewest_stages((P, Q, R), after(r="q", q="r"))


LETTERS = "pqrst"


@given(
    pairs=st.sets(st.tuples(st.sampled_from(LETTERS), st.sampled_from(LETTERS)), max_size=8),
)
def test_a_cycle_is_found_exactly_if_there_is_one(pairs: set[tuple[str, str]]) -> None:
    asked = after(**{one: "".join(b for a, b in pairs if a == one) for one, _ in pairs})
    found = cycle_in(asked)
    try:
        stages = fewest_stages(tuple(map(Fact, LETTERS)), asked)
    except CyclicOrder:
        assert found
        assert all(other in asked[one] for one, other in zip(found, (*found[1:], found[0]), strict=True))
    else:
        assert not found
        assert all(stages.get(goal, 0) > stages.get(before, 0) for goal in asked for before in asked[goal])
