"""News that is older than what is known of the same thing is passed over; all else of it is believed."""

import pytest

from app.domain.world_model import belief_change, place_of, revise_beliefs
from app.domain.world_model.timeliness import (
    DatedFact,
    beliefs_contradicting,
    newer_subjects,
    subjects_of,
    without_outdated,
)
from planner import Fact
from tests.app.sample_store import Store

STORE = Store()
CARRIED = revise_beliefs(STORE.facts, [STORE.fact("in(sample_1, store_2)")])


def test_news_of_a_sample_that_newer_is_known_of_is_passed_over_what_it_says_of_its_robot_is_not() -> None:
    news = [STORE.fact("in(sample_1, interchange_2)"), STORE.fact("near(yard_1, interchange_2)")]
    known = [DatedFact(fact=STORE.fact("in(sample_1, store_2)"), source="report of store_2", at_s=60.0)]
    change = without_outdated(CARRIED, belief_change(CARRIED, news), newer_subjects(known, 50.0))
    after = change.apply(CARRIED)
    assert STORE.fact("in(sample_1, store_2)") in after
    assert STORE.fact("in(sample_1, interchange_2)") not in after
    assert STORE.fact("near(yard_1, interchange_2)") in after
    assert STORE.fact("vacant(interchange_2)") in after


def test_news_is_believed_if_what_is_known_is_as_old_or_of_a_source_that_does_not_count() -> None:
    known = [DatedFact(fact=STORE.fact("in(sample_1, store_2)"), source="report of store_2", at_s=60.0)]
    change = belief_change(CARRIED, [STORE.fact("in(sample_1, interchange_2)")])
    assert without_outdated(CARRIED, change, newer_subjects(known, 60.0)) == change
    assert without_outdated(CARRIED, change, newer_subjects(known, 50.0, but=["report of store_2"])) == change


def test_what_was_laid_where_something_else_is_known_to_lie_since_is_nowhere_known() -> None:
    facts = revise_beliefs(STORE.facts, [STORE.fact("in(sample_4, bay_7)")])
    known = [DatedFact(fact=STORE.fact("in(sample_4, bay_7)"), source="operator", at_s=60.0)]
    change = belief_change(facts, [STORE.fact("in(sample_1, bay_7)")])
    after = without_outdated(facts, change, newer_subjects(known, 50.0)).apply(facts)
    assert (place_of("sample_4", after), place_of("sample_1", after)) == ("bay_7", None)
    assert STORE.fact("vacant(door_1)") in after


def test_what_follows_from_other_facts_is_no_subject_of_its_own() -> None:
    assert subjects_of(STORE.fact("vacant(bay_7)")) == frozenset()
    assert subjects_of(STORE.fact("can(yard_1, DOCK)")) == frozenset()


@pytest.mark.parametrize(
    ("gone", "now"),
    [
        (Fact("object_position", ("sample_1", "in", "door_1")), {"sample_1 in bay_3", "sample_2 in door_1"}),
        (Fact("vacant", ("bay_3",)), {"sample_1 in bay_3"}),
        (Fact("clear", ("bay_4", "aisle_1")), {"store_1 near bay_4"}),
        (Fact("robot_position", ("store_1", "near", "bay_1")), {"store_1 near bay_4"}),
        (Fact("can", ("store_1", "DOCK")), set()),
    ],
)
def test_what_is_so_instead_of_a_fact_is_said_of_the_same_things(gone: Fact, now: set[str]) -> None:
    believed = [
        DatedFact(fact=Fact(predicate, args), source="operator", at_s=3.0)
        for predicate, args in (
            ("object_position", ("sample_1", "in", "bay_3")),
            ("object_position", ("sample_2", "in", "door_1")),
            ("robot_position", ("store_1", "near", "bay_4")),
        )
    ]
    assert {" ".join(one.fact.args) for one in beliefs_contradicting(gone, believed)} == now
