"""What is known of the facts that a hold keeps: lost once, restored, lost again."""

from collections.abc import Sequence

from app.domain.goal_language.kept_facts import HoldFact
from app.domain.kept_record import KeptRecord
from app.domain.world_model import Facts, revise_beliefs
from tests.app.sample_store import Store

STORE = Store()
LIES = HoldFact(predicate="in", args=("sample_2", "bay_2"))
STANDS = HoldFact(predicate="near", args=("yard_1", "door_1"))
BOTH = (LIES, STANDS)
KEPT = KeptRecord(achieved=(LIES,))


def after(*news: str, gone: Sequence[str] = ()) -> Facts:
    return revise_beliefs(
        STORE.facts, [STORE.fact(one) for one in news], gone=[STORE.fact(one) for one in gone]
    )


def observed(record: KeptRecord, *news: str, in_work: Sequence[HoldFact] = ()) -> KeptRecord:
    return record.observe(BOTH, STORE.world, after(*news), in_work=in_work)


def told(record: KeptRecord) -> list[tuple[str, str, int]]:
    return [(str(one.fact), one.now, one.number) for one in record.lost]


def test_what_was_never_true_is_not_lost_and_counts_once_it_is_true() -> None:
    assert observed(KeptRecord()) == KEPT
    assert observed(KEPT, "near(yard_1, door_1)").achieved == BOTH


def test_what_a_goal_brings_about_does_not_count_before_the_goal_is_over() -> None:
    assert observed(KEPT, "near(yard_1, door_1)", in_work=[STANDS]) == KEPT


def test_a_loss_is_noted_with_what_is_believed_now_and_stays_until_it_is_true_again() -> None:
    lost = observed(KEPT, "in(sample_2, bay_3)")
    assert told(lost) == [("in(sample_2, bay_2)", "sample_2 is in bay_3", 1)]
    assert observed(lost, "in(sample_2, bay_3)") == lost
    assert told(observed(lost)) == []
    assert told(observed(observed(lost), "in(sample_2, bay_4)")) == [
        ("in(sample_2, bay_2)", "sample_2 is in bay_4", 2)
    ]


def test_what_a_goal_restores_is_the_same_loss_wherever_it_is_meanwhile() -> None:
    asked = observed(KEPT, "in(sample_2, bay_3)").answered(1, goal="goal-1")
    carried = observed(asked, "in(sample_2, bay_4)", in_work=[LIES])
    assert told(carried) == [("in(sample_2, bay_2)", "sample_2 is in bay_4", 1)]
    assert carried.lost[0].goal == "goal-1"
    assert told(observed(carried, in_work=[LIES])) == told(carried)
    assert observed(carried).lost == ()


def test_what_could_not_be_restored_is_a_new_loss_once_it_is_elsewhere() -> None:
    nowhere = KEPT.observe(BOTH, STORE.world, after(gone=["in(sample_2, bay_2)"]), in_work=())
    assert told(nowhere) == [("in(sample_2, bay_2)", "sample_2 is in an unknown place", 1)]
    refused = nowhere.answered(1, reason="it is not known where sample_2 is")
    assert not refused.lost[0].is_unanswered
    found = observed(refused, "in(sample_2, bay_3)")
    assert told(found) == [("in(sample_2, bay_2)", "sample_2 is in bay_3", 2)]
    assert found.lost[0].is_unanswered
