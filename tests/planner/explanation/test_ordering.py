"""Orderings in words: what one action would undo, what keeps them."""

import pytest

from planner import (
    CausalLink,
    Fact,
    Keeping,
    KnowledgeBase,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
)
from planner.explanation.ordering import Reasons

FREE = Fact("vacant", ("bay_1",))
CLEAR = Fact("clear", ("door_1", "yard"))
NAMES = {"a1": "a1 RELEASE2", "a2": "a2 NAVIGATE"}


def action(name: str, **facts: tuple[Fact, ...]) -> PlanNetAction:
    slots = dict.fromkeys(("preconditions", "deletes", "intended_effects", "other_effects"), ())
    return PlanNetAction(
        id=name,
        tag=NAMES[name].split()[1],
        arguments={},
        agents=(f"robot_{name}", "both"),
        duration_s=1.0,
        earliest_start_s=0.0,
        latest_start_s=0.0,
        description="",
        **{**slots, **facts},  # type: ignore[arg-type]
    )


def why(
    knowledge_base: KnowledgeBase,
    ordering: Ordering,
    one: PlanNetAction,
    other: PlanNetAction,
    *links: CausalLink,
) -> str:
    net = PlanNet(goals=(), actions=(one, other), causal_links=links, orderings=(ordering,), recruitment={})
    return Reasons(net, NAMES, knowledge_base).why(ordering)


def ordering(reason: OrderingReason, kept_by: Keeping | None = None) -> Ordering:
    return Ordering(before="a1", after="a2", reason=reason, kept_by=kept_by)


def test_what_the_later_action_ends_is_what_the_earlier_needs(knowledge_base: KnowledgeBase) -> None:
    words = why(
        knowledge_base,
        ordering(OrderingReason.THREAT),
        action("a1", preconditions=(FREE, CLEAR)),
        action("a2", deletes=(CLEAR,)),
    )
    assert words == "a1 RELEASE2 needs that door_1 is clear of robots in yard, which a2 NAVIGATE ends"


def test_what_the_earlier_action_would_undo_is_what_the_later_brings_about(
    knowledge_base: KnowledgeBase,
) -> None:
    words = why(
        knowledge_base,
        ordering(OrderingReason.THREAT),
        action("a1", deletes=(FREE, CLEAR)),
        action("a2", other_effects=(FREE,)),
        CausalLink(producer="a2", fact=FREE, consumer="goal"),
    )
    assert words == "a1 RELEASE2 would undo that bay_1 has room for an object, which a2 NAVIGATE brings about"


@pytest.mark.parametrize(
    ("keeping", "words"),
    [
        (None, "both can do only one at a time"),
        (Keeping.ROBOT, "both can do only one at a time"),
        (Keeping.SENSING, "both can do only one at a time; the robot waits until it senses it"),
        (Keeping.CLEARANCE, "both can do only one at a time; the robot waits until it is cleared"),
    ],
)
def test_what_keeps_an_ordering_is_said(
    knowledge_base: KnowledgeBase, keeping: Keeping | None, words: str
) -> None:
    kept = ordering(OrderingReason.RESOURCE, keeping)
    assert why(knowledge_base, kept, action("a1"), action("a2")) == words


def test_an_order_of_goals_names_both(knowledge_base: KnowledgeBase) -> None:
    words = why(
        knowledge_base,
        ordering(OrderingReason.ORDER, Keeping.CLEARANCE),
        action("a1"),
        action("a2"),
        CausalLink(producer="a1", fact=FREE, consumer="goal"),
        CausalLink(producer="a2", fact=CLEAR, consumer="goal"),
    )
    assert words == (
        "the plan is edited so that door_1 is clear of robots in yard only once bay_1 has room for an object; "
        "the robot waits until it is cleared"
    )
