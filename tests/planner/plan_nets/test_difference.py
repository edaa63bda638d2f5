"""How plan-nets differ: what a robot still does in the same order is kept."""

from collections.abc import Sequence
from itertools import combinations, product

import pytest

from planner import PlanNet, PlanNetAction
from planner.plan_nets.difference import compare


def one_after_the_other(jobs: Sequence[str]) -> PlanNet:
    """One robot does these jobs; an action's id is its number."""
    actions = tuple(
        PlanNetAction(
            id=str(number),
            tag="WORK",
            arguments={"job": job},
            agents=("robot",),
            preconditions=(),
            deletes=(),
            intended_effects=(),
            other_effects=(),
            duration_s=10.0,
            earliest_start_s=10.0 * number,
            latest_start_s=10.0 * number,
            description="",
        )
        for number, job in enumerate(jobs)
    )
    return PlanNet(goals=(), actions=actions, causal_links=(), orderings=(), recruitment={})


def in_order(jobs: Sequence[str]) -> set[tuple[str, ...]]:
    """Every choice of the jobs, in their order."""
    return {chosen for count in range(len(jobs) + 1) for chosen in combinations(jobs, count)}


@pytest.mark.parametrize("before", ["abcd", "aaba"])
def test_as_many_actions_are_kept_as_the_robot_does_in_the_same_order_in_both_plans(before: str) -> None:
    old = one_after_the_other(before)
    for after in product("abcd", repeat=4):
        new = one_after_the_other(after)
        kept = compare(old.actions, new).kept
        assert list(kept) == sorted(kept)
        assert list(kept.values()) == sorted(set(kept.values()))
        assert all(before[int(one)] == after[int(other)] for one, other in kept.items())
        assert len(kept) == max(map(len, in_order(before) & in_order(after))), after
