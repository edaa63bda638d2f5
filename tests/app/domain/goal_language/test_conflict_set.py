"""The smallest set of constraints that cannot be kept together."""

import random
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.domain.goal_language.check import check_request
from app.domain.goal_language.conflict_set import smallest_conflict
from app.domain.goal_language.constraints import Constraints
from app.domain.goal_language.issues import GoalIssue
from robots.wire import SymbolicFact
from tests.app.sample_store import Store

STORE = Store()
TO_BAY_7 = (SymbolicFact(predicate="in", args=("sample_1", "bay_7")),)
ALL = 1000
"""More than there are sets of as many things as are drawn."""


@given(
    parts=st.integers(1, 8),
    clashes=st.lists(st.sets(st.integers(0, 7), min_size=1, max_size=4), min_size=1, max_size=5),
    tries=st.sampled_from([0, ALL]),
)
def test_none_of_it_can_be_left_out_and_of_all_tried_none_is_smaller(
    parts: int, clashes: list[set[int]], tries: int
) -> None:
    known = [clash for clash in clashes if max(clash) < parts]

    def conflict(some: Sequence[int]) -> bool:
        return any(clash <= set(some) for clash in known)

    if not known:
        return
    found = smallest_conflict(range(parts), conflict, tries=tries)
    assert conflict(found)
    assert not any(conflict([one for one in found if one != left_out]) for left_out in found)
    assert list(found) == sorted(found)
    if tries:
        assert len(found) == min(map(len, known))


def test_nothing_is_blamed_if_there_is_a_conflict_without_any_of_it() -> None:
    assert smallest_conflict("abc", lambda some: True, tries=ALL) == ()


@pytest.mark.parametrize("seed", range(10))
def test_of_any_constraints_those_are_blamed_of_which_none_can_be_left_out(seed: int) -> None:
    dice = random.Random(seed)
    robots = [robot.name for robot in STORE.world.robots]
    places = [place.name for place in STORE.world.locations]

    def issues(constraints: Constraints) -> tuple[GoalIssue, ...]:
        return check_request(TO_BAY_7, constraints, STORE.world, STORE.facts, STORE.base)

    found = 0
    while found < 3:
        given = Constraints(
            robots=dice.sample(robots, 3) if dice.random() < 0.3 else (),
            without=dice.sample(robots, dice.randint(0, 2)),
            avoid=dice.sample(places, dice.randint(0, 5)),
            keep_empty=dice.sample(places, dice.randint(0, 2)),
        )
        told = issues(given)
        if not told or {issue.code for issue in told} != {"constraints-too-tight"}:
            continue
        found += 1
        blamed = [part for part in given.parts if part.words[0] in told[0].constraints]
        assert len(blamed) == len(told[0].constraints) > 0
        assert issues(Constraints.all_of(blamed)) == told
        for left_out in blamed:
            assert not issues(Constraints.all_of(part for part in blamed if part is not left_out)), told


def tight(constraints: Constraints) -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
    """The constraints that are blamed, and what they withhold."""
    issues = check_request(TO_BAY_7, constraints, STORE.world, STORE.facts, STORE.base)
    assert {issue.code for issue in issues} <= {"constraints-too-tight"}
    return [(issue.constraints, issue.choices) for issue in issues]


def test_constraints_that_do_not_matter_are_not_blamed() -> None:
    given = Constraints(
        without=("yard_1", "store_1", "store_2"), avoid=("bay_3", "door_2"), keep_empty=("bay_9",)
    )
    assert tight(given) == [(("without store_2",), ("store_2",))]
    assert tight(given.model_copy(update={"without": ("yard_1", "store_1")})) == []


def test_two_constraints_that_only_together_cannot_be_kept_are_both_blamed() -> None:
    given = Constraints(robots=("yard_1", "store_1", "store_2"), without=("yard_1",), avoid=("bay_3",))
    withheld = ("yard_1", "yard_2")
    assert tight(given) == [(("only with yard_1, store_1 and store_2", "without yard_1"), withheld)]
