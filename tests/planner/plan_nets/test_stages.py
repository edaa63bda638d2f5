"""Goals in stages: what belongs to a later one starts when the earlier ones are achieved."""

from itertools import pairwise

import pytest

from planner import Fact, InvalidPlan, OrderingReason
from planner.plan_nets.extraction import extract
from planner.plan_nets.stages import goals_by_stage, without_redundant_by_stage
from tests.planner.plan_nets.test_extraction import act

P, Q, R = map(Fact, "pqr")
ONE = act("one", intends=["p"])
OTHER = act("other", intends=["q"])
LAST = act("last", intends=["r"])


def orderings(*sequence, goals=(P, Q, R), **stages):  # type: ignore[no-untyped-def]
    order = extract(sequence, frozenset(), goals, {Fact(name): stage for name, stage in stages.items()})
    tags = [action.tag for action in order.actions]
    return {(tags[one], tags[two]): reason for (one, two), reason in order.orderings.items()}


def test_without_stages_independent_actions_are_not_ordered() -> None:
    assert orderings(ONE, OTHER, LAST) == {}


def test_a_later_stage_follows_what_achieves_the_earlier_one() -> None:
    found = orderings(ONE, OTHER, LAST, r=1)
    assert found == {("one", "last"): OrderingReason.STAGE, ("other", "last"): OrderingReason.STAGE}


def test_three_stages_follow_each_other_and_only_the_nearest_orderings_are_recorded() -> None:
    assert orderings(ONE, OTHER, LAST, q=1, r=2) == {
        ("one", "other"): OrderingReason.STAGE,
        ("other", "last"): OrderingReason.STAGE,
    }


def test_an_ordering_that_is_there_for_another_reason_keeps_it() -> None:
    needy = act("last", needs=["p"], intends=["r"])
    assert orderings(ONE, needy, goals=(P, R), r=1) == {("one", "last"): OrderingReason.CAUSAL}


def test_a_goal_that_holds_already_is_waited_for_by_nothing() -> None:
    order = extract([LAST], frozenset({P}), (P, R), {R: 1})
    assert order.orderings == {}


def test_an_action_of_a_later_stage_that_begins_too_early_is_refused() -> None:
    early = act("early", intends=["x"])
    with pytest.raises(InvalidPlan):
        extract([early, ONE, act("last", needs=["x"], intends=["r"])], frozenset(), (P, R), {R: 1})


def test_within_a_stage_redundant_actions_go() -> None:
    idle = act("idle", intends=["x"])
    kept = without_redundant_by_stage([ONE, LAST, idle], frozenset(), (P, R), {R: 1})
    assert kept == (ONE, LAST)


def test_goals_add_up_from_stage_to_stage() -> None:
    stages = goals_by_stage((P, Q, R), {P: 3, R: 5})
    assert stages == [(Q,), (P, Q), (P, Q, R)]
    assert all(set(one) < set(other) for one, other in pairwise(stages))
